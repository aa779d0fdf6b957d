"""A channel that comes later than it declares: current, motion or voltage against the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.estimate.diagnosis.fault import (
    Effect,
    Hypothesis,
    Remedy,
    Words,
    acting,
    changed_voltage,
    series,
    short,
    word,
)
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.scales import least_delay_s
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.effects.timing.motion_delay import MOTION_DELAY
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF

Floats = NDArray[np.float64]

SAMPLES = (0.5, 2.0, 5.0, 12.0)  # by which a channel is tried to be late
OF_VOLTAGE = (1.0, 3.0, 8.0)
AROUND = (0.0, -0.3, -0.15, 0.15, 0.3)  # samples about a size found, that are tried too
LATEST = 60.0  # samples
EARLY = (0.4, 0.9)  # of the declared delay, by which a channel is tried to be early,
SHORT = 0.98  # of it, that a search may take: its steps go a little beyond
LITTLE = 0.05  # samples: where that is more
BEYOND, LEAST = 4.0, 0.03  # uncertainties of the declared delay, and samples, that a lag must be
ROUNDING = 1e-9
DELAYS = {CURRENT: CURRENT_DELAY, POSITION: MOTION_DELAY, SPEED: MOTION_DELAY}


def late(values: Floats, samples: float) -> Floats:
    """(count,) so many samples later, by straight lines; the first value before."""
    place = np.arange(len(values))
    return np.asarray(np.interp(place - samples, place, values))


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """One for each measured channel that can be late by itself."""
    period = min(r.timeline.period_s for r in records)
    own = min(r.capture.period_s for r in records)  # a log's grid is finer
    names = {m.block.name for r in records for m in r.measured}
    found = [
        _hypothesis(
            name,
            acting(quantity),
            SAMPLES,
            (period, own),
            quantity,
            early=_earliest(records, name),
            least=max(BEYOND * _doubt(records, name), LEAST * own),
        )
        for name, quantity in DELAYS.items()
        if name in names
    ]
    if all(r.sensed.channel is not None and r.sensed.shows_emf for r in records):
        periods = (period, own)
        late = _hypothesis(VOLTAGE, _late_voltage, OF_VOLTAGE, periods, remedy=_declared_later)
        found.append(late)
    return found


def _earliest(records: Sequence[MotorRecord], name: str) -> float:
    """s, at most 0, by which a channel may come before its declared delay: no reading is ahead of
    its own instant. 0 where the fit has its delay among its unknowns.
    """
    if any(one.quantity is DELAYS[name] for r in records for one in r.instances):
        return 0.0
    blocks = (b for r in records if (b := r.block(name)))
    return SHORT * max((least_delay_s(b) for b in blocks), default=0.0)


def _doubt(records: Sequence[MotorRecord], name: str) -> float:
    """s, the standard uncertainty of a declared delay."""
    blocks = (b for r in records if (b := r.block(name)))
    return max((b.channel.delay_uncertainty_s for b in blocks), default=0.0)


def _declared_later(capture: Capture, by_s: float) -> list[Capture]:
    """The capture whose voltage is declared to come later, by about that and by whole samples."""
    volts, period = capture.channels[VOLTAGE], capture.period_s
    sizes = dict.fromkeys((round(by_s / period) * period, *(by_s + k * period for k in AROUND)))
    later = [replace(volts, delay_s=volts.delay_s + size) for size in sizes if size >= 0.0]
    return [replace(capture, channels={**capture.channels, VOLTAGE: one}) for one in later]


def _late_voltage(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """The source rises in time with its command, and the back-EMF is read late."""
    samples = float(size[0]) / record.timeline.period_s
    volts, place = record.volts.copy(), np.arange(record.timeline.count)
    ahead = int(np.ceil(samples - ROUNDING))
    for part in record.timeline.parts:
        volts[part.slice] = record.volts[np.minimum(place[part.slice] + ahead, part.stop - 1)]
    out = changed_voltage(record, values, own, volts)
    for k, y in series(record, values, own, EMF):
        out[k] = out[k] + (late(y, samples) - y)[record.measured[k].where]
    return out


def _hypothesis(
    name: str,
    effect: Effect,
    sizes: Sequence[float],
    periods: tuple[float, float],
    quantity: InfluenceQuantity | None = None,
    remedy: Remedy | None = None,
    early: float = 0.0,
    least: float = 0.0,
) -> Hypothesis:
    """``periods``: of the fit's grid, by which it is tried, and of the samples. ``early`` (s, at
    most 0): by how much it may come before what it declares.
    """
    what, (period, own) = word(name), periods

    def words(size: Floats) -> Words:
        return Words(
            what,
            f"the {what} comes {1e6 * abs(size[0]):.0f} µs {'later' if size[0] > 0 else 'earlier'} "
            f"than it declares ({abs(size[0]) / own:.1f} samples)",
            f"declare the delay of the {what}, or look for a buffer or a slow conversion in it",
        )

    tried = [(k * period,) for k in sizes]
    tried += [(share * early,) for share in EARLY] if -early > LITTLE * period else []
    return Hypothesis(
        f"{short(name)}_lag", effect, tuple(tried), (period,), (early,),
        (LATEST * period,), words, quantity=quantity, remedy=remedy, least=least,
        stepwise=remedy is not None,
    )  # fmt: skip
