"""An encoder, or its counter, that does not follow fast edges: it misses some, or all above a rate.

A counter that misses a small share of them is put to the data at each of many rates, since between
two levels of the speed all rates are alike, and a search would not find from one to the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.diagnosis.fault import Hypothesis, Words, nothing, series
from motorid.estimate.diagnosis.faults import lost_samples
from motorid.estimate.effects import scales
from motorid.estimate.effects.reading import missed_counts
from motorid.estimate.effects.reading.missed_counts import MISSED_COUNTS, behind, missed_share
from motorid.estimate.fit.block_regression import Start, blocks, electrical, mechanical
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect

Floats = NDArray[np.float64]

LOST, MISSED = "encoder_loses_counts", "counts_missed"
TOP = 0.97  # of the highest speed: where edges may be lost
BELOW = 0.85  # of it: surely not
CLEAR = 0.02  # relative, by which the motor must be faster than its encoder says
RATES = np.linspace(0.2, 1.0, 65)[:-1]  # of the highest speed: above which some may be missed
SOME = 0.01  # of the counts, to begin with
LEAST = 5e-4  # of them: less is no counter's, but what else a model lacks
# counts that an edge costs at most: the decoder sees neither that track's nor the other's
CYCLE = 4.0


def seen(records: Sequence[MotorRecord]) -> tuple[Hypothesis, Start] | None:
    """Edges lost above some speed: at the highest speeds the back-EMF is more than they say."""
    positions = [m for r in records for m in r.measured if m.block.name == POSITION]
    b = blocks(records)
    if b is None or not positions:
        return None
    peak = float(np.abs(b.speed[b.settled]).max(initial=0.0))
    motor = electrical(b, b.settled & (np.abs(b.speed) < BELOW * peak))
    use = b.settled & (np.abs(b.speed) > TOP * peak)
    if motor is None:
        return None
    R, K = motor
    if float(np.median((b.volts - R * b.current)[use] / (K * b.speed[use]))) < 1.0 + CLEAR:
        return None
    slow = np.abs(b.speed) < BELOW * peak
    begin = Start((TOP * peak,), {"R": R, "K": K, **mechanical(b, K, slow)})
    return _hypothesis(peak, positions[0].resolution), begin


def _hypothesis(peak: float, step: float) -> Hypothesis:
    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        out, most = nothing(record), float(size[0]) * record.timeline.period_s
        for k, y in series(record, values, own, POSITION):
            moved = np.diff(y, prepend=y[0])
            out[k] = np.cumsum(np.clip(moved, -most, most) - moved)[record.measured[k].where]
        return out

    def words(size: Floats) -> Words:
        rate = f", {size[0] / step:.3g} counts a second" if step else ""
        return Words(
            "position",
            f"the encoder loses counts above {size[0]:.4g} rad/s{rate}",
            "use a faster counter or fewer lines, or run slower",
        )

    return Hypothesis(
        LOST, effect, ((peak,),), (0.01 * peak,), (0.5 * peak,), (1.5 * peak,),
        words,
    )  # fmt: skip


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """A counter that misses a share of its counts above some rate, where motion was measured."""
    top = max(scales.speed(record) for record in records)
    if not top > 0.0 or any(_estimated(record) for record in records):
        return []
    rates = (top * RATES).tolist()
    resolution = _resolution(records)

    def words(size: Floats) -> Words:
        share, above = 100.0 * float(size[0]), float(size[1])
        rate = f", {above / resolution:.3g} counts a second" if resolution else ""
        return Words(
            "encoder",
            f"the encoder's counter misses {share:.2g} % of its counts above {above:.4g} rad/s"
            f"{rate}",
            MISSED_COUNTS.remedy,
        )

    return [
        Hypothesis(
            MISSED, _missing, tuple((SOME, rate) for rate in rates), (SOME, SOME * top),
            (0.0, rates[0]), (missed_counts.MOST, top), words, quantity=MISSED_COUNTS,
            place=lambda size: missed_counts.place_of(float(size[1])), afterwards=True,
            scatter=_by_chance, least=max(LEAST, *map(_declared, records)),
        )
    ]  # fmt: skip


def unsized(record: MotorRecord) -> list[Suspect]:
    """What jumps of a position show, but for lost counts that are an unknown of the record."""
    found = lost_samples.suspects(record.capture, record.timeline)
    return [s for s in found if s.code != LOST or not _estimated(record)]


def jumps(records: Sequence[MotorRecord]) -> bool:
    """Those of a position show that counts are lost."""
    return any(s.code == LOST for record in records for s in unsized(record))


def _estimated(record: MotorRecord) -> bool:
    return any(one.quantity is MISSED_COUNTS for one in record.instances)


def _missing(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """What is missed at a share and a rate (rad/s), of either way to show the motion."""
    out, (share, above) = nothing(record), (float(x) for x in size)
    for k, y in series(record, values, own, POSITION, SPEED):
        m, period_s = record.measured[k], record.timeline.period_s
        at_position = m.block.name == POSITION
        course = behind(y, period_s, above) if at_position else y * missed_share(y, above)
        out[k] = -share * course[m.where]
    return out


def _by_chance(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """rad² or (rad/s)² (n,): edges are missed one by one, each with all counts of a cycle."""
    missing = _missing(record, values, own, size)
    each = zip(record.measured, missing, strict=True)
    return [CYCLE * m.resolution * np.abs(missed) for m, missed in each]


def _declared(record: MotorRecord) -> float:
    """Standard uncertainty of the motion's gain: so much contradicts nobody."""
    measured = scales.moving(record)
    return measured.channel.gain_uncertainty if measured is not None else 0.0


def _resolution(records: Sequence[MotorRecord]) -> float:
    """rad of a count; 0: nobody says."""
    positions = (m for r in records for m in r.measured if m.block.name == POSITION)
    return max((m.resolution for m in positions), default=0.0)
