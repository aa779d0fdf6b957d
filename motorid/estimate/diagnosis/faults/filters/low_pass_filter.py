"""A low-pass in a channel that is said to have none: of a circuit, or done to a log afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting, changed_voltage, series
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.smoothing import SMOOTHED
from motorid.estimate.effects.reading.smoothing_kernels import Smoothing
from motorid.estimate.effects.reading.speed_filter import SPEED_FILTER
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.time_grid import IRREGULAR
from motorid.estimate.signals.voltage_low_pass import REMEDY, behind, described

Floats = NDArray[np.float64]

SAMPLES = (0.5, 2.0, 6.0, 20.0)  # time constants that are tried
LONGEST = 500.0  # samples
SHORTEST = 1e-3
OF_VOLTAGE = (1.0, 3.0, 8.0)  # samples: the same of a board's voltage
AROUND = (1.0, 0.8, 0.9, 1.1, 1.25)  # of a time constant found, that are declared too
FILTERS = {CURRENT: CURRENT_FILTER, SPEED: SPEED_FILTER}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """For the current and for a measured speed: a circuit, and every way to smooth digitally.

    What shows an edge before it comes is done to logs alone.
    """
    period = min(r.timeline.period_s for r in records)
    names = {m.block.name for r in records for m in r.measured}
    even = all(r.timeline.jitter <= IRREGULAR for r in records)
    logged = all(r.sensed.waveform is not None for r in records)
    found = [_of(name, period) for name in FILTERS if name in names]
    ways = (
        (name, *way) for name in FILTERS if name in names and even
        for way in SMOOTHED[name].items() if logged or way[0].behind
    )  # fmt: skip
    if not logged and all(r.sensed.channel is not None and r.sensed.shows_emf for r in records):
        found.append(_of_voltage(period))
    return found + [_smoothed(*way) for way in ways]


def _smoothed(name: str, way: Smoothing, quantity: InfluenceQuantity) -> Hypothesis:
    def words(size: Floats) -> Words:
        return Words(name, shown(name, way, float(size[0])), quantity.remedy)

    return Hypothesis(
        f"{name}_smoothed", acting(quantity), tuple((w,) for w in way.sizes), (1.0,), (0.0,),
        (float(way.most),), words, quantity=quantity, afterwards=True, whole=way.whole,
        stepwise=way.behind > 0.0,
    )  # fmt: skip


def shown(name: str, way: Smoothing, size: float) -> str:
    """What the readings of a channel smoothed so show, in words."""
    shows = "reads" if way.behind else "shows its edges before they come,"
    return f"the {name} {shows} as behind {way.how} ({way.wide(size)})"


def _of(name: str, period: float) -> Hypothesis:
    def words(size: Floats) -> Words:
        return Words(
            name,
            f"the {name} reads as behind {described(float(size[0]))}",
            f"take the filter out of the {name} channel, or correct the readings for it",
        )

    return Hypothesis(
        f"{name}_filtered", acting(FILTERS[name]), tuple((k * period,) for k in SAMPLES), (period,),
        (SHORTEST * period,), (LONGEST * period,), words, quantity=FILTERS[name],
    )  # fmt: skip


def _of_voltage(period: float) -> Hypothesis:
    """Of a voltage that a board reads at the motor, as of a divider with a capacitor."""

    def words(size: Floats) -> Words:
        return Words(
            VOLTAGE.replace("_", " "),
            f"the voltage reads as behind {described(float(size[0]))}",
            REMEDY,
        )

    return Hypothesis(
        "voltage_filtered", _filtered_voltage, tuple((k * period,) for k in OF_VOLTAGE), (period,),
        (SHORTEST * period,), (LONGEST * period,), words, remedy=_declared_filter,
    )  # fmt: skip


def _declared_filter(capture: Capture, size_s: float) -> list[Capture]:
    """The capture whose voltage is declared to pass a low-pass of about that time constant."""
    volts = capture.channels[VOLTAGE]
    return [
        replace(capture, channels={**capture.channels, VOLTAGE: behind(volts, share * size_s)})
        for share in AROUND
    ]


def _filtered_voltage(
    record: MotorRecord, values: Floats, own: Floats, size: Floats
) -> list[Floats]:
    """The source is what it was before the low-pass, and the back-EMF is read behind it."""
    share = float(np.exp(-record.timeline.period_s / size[0]))
    volts = record.volts.copy()
    volts[1:] += np.diff(record.volts) * share / (1.0 - share)
    out = changed_voltage(record, values, own, volts)
    for k, y in series(record, values, own, EMF):
        out[k] = out[k] + (_behind(y, share) - y)[record.measured[k].where]
    return out


def _behind(values: Floats, share: float) -> Floats:
    """(count,) behind a recursive average that keeps ``share`` of what it was, settled at first."""
    out, now = np.empty_like(values), float(values[0])
    for k, value in enumerate(values.tolist()):
        now = out[k] = value + share * (now - value)
    return out
