"""A supply that gives no more than some current, and lets its voltage fall instead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY
from motorid.estimate.diagnosis.fault import Hypothesis, Words, changed_voltage
from motorid.estimate.diagnosis.faults.motion import measured_speed
from motorid.estimate.fit.block_regression import Start, blocks, mechanical, usual
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.time_grid import Part
from motorid.program import StepKind

Floats = NDArray[np.float64]

SAGS = 0.05  # of the part's level, by which the voltage must fall
BACK = 0.9  # of a fall: where the supply has recovered
SMOOTH = 8  # samples
HEAD = 16  # samples after a command, which a late voltage shows wrongly
FEWEST = 24  # samples of a recovery
FLAT = 0.1  # of the limit, by which the mean current may change from the first third to
# the last; before, a capacitor may give up to twice that more
LEAVES = 0.3  # of the limit, by which the current falls once the voltage has recovered
ON_ITS_WAY = 0.2  # of a fall: a capacitor gives more than the limit until there
MISSING = 0.05  # of the commanded voltage, that the motor must answer as if it lacked
BLOCKS = 3  # that must lack it

DRIVEN = (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)

ACTION = "set the supply's current limit higher, or drive with lower steps"


@dataclass(frozen=True)
class Sag:
    """A stretch in which the voltage rose from ``low_v`` to ``high_v`` at one current."""

    current_a: float
    low_v: float
    high_v: float
    start_s: float


def suspects(record: MotorRecord) -> list[Suspect]:
    """A limit that the measured voltage shows; the fit follows it, so it does no harm."""
    found = sag(record)
    if found is None:
        return []
    evidence = (
        f"the voltage rose from {found.low_v:.3g} to {found.high_v:.3g} V at {found.start_s:.3g} s "
        f"while the current stood at {found.current_a:.3g} A"
    )
    return [Suspect("supply_limited", "supply", evidence, ACTION, "named")]


def sag(record: MotorRecord) -> Sag | None:
    """The first stretch of a measured voltage that shows a limit of the supply's current."""
    current = next((m for m in record.measured if m.block.name == CURRENT), None)
    volts = _measured(record)
    if current is None or volts is None:
        return None
    place = np.arange(record.timeline.count)
    amperes = np.abs(np.interp(place, current.keep, current.values))
    for part in record.timeline.parts:
        if part.kind in DRIVEN and part.level and not part.discontinuous:
            found = _in_part(part, volts, amperes, record)
            if found is not None:
                return found
    return None


def _measured(record: MotorRecord) -> Floats | None:
    """The voltage at the motor or else at the bridge's supply, at every tick, (count,)."""
    if record.sensed.shows_emf:
        return np.abs(record.sensed.volts)
    supply = record.capture.get(SUPPLY)
    if supply is None:
        return None
    known = record.timeline.spread(supply.values)
    kept = np.flatnonzero(np.isfinite(known))
    return np.interp(np.arange(len(known)), kept, known[kept]) if len(kept) else None


def _in_part(part: Part, volts: Floats, amperes: Floats, record: MotorRecord) -> Sag | None:
    """A plateau of the current under a voltage that recovers; once it has, the current falls.

    A supply with a resistance recovers as far as the current falls, and so shows no plateau. In a
    part whose current comes in pulses the voltage rises with the speed by itself.
    """
    box = np.ones(SMOOTH) / SMOOTH
    if part.stop - part.start < HEAD + 2 * FEWEST:
        return None
    v, i = (np.convolve(y[part.slice][HEAD:], box, "valid") for y in (volts, amperes))
    level, low = float(np.median(v[-FEWEST:])), int(np.argmin(v))
    fall = level - float(v[low])
    begin, back = (
        low + int(np.argmax(v[low:] >= v[low] + share * fall)) for share in (ON_ITS_WAY, BACK)
    )
    if fall < SAGS * level or back - begin < FEWEST:
        return None
    limit, end = float(np.median(i[begin:back])), float(np.median(i[-FEWEST:]))
    third = (back - begin) // 3
    change = float(np.mean(i[begin : begin + third]) - np.mean(i[back - third : back]))
    above = float(np.mean(i[low : begin + 1])) - limit
    if max(abs(change), above / 2) > FLAT * limit or limit - end < LEAVES * limit:
        return None
    start_s = (part.start + HEAD + begin) * record.timeline.period_s
    return Sag(limit, float(v[begin]), float(v[back]), start_s)


def seen(records: Sequence[MotorRecord]) -> tuple[Hypothesis, Start] | None:
    """A limit where the motor's voltage was commanded only: for a while it gets less of it."""
    b = blocks(records)
    if b is None or any(r.sensed.shows_emf for r in records):
        return None
    motor = usual(b)
    if motor is None:
        return None
    R, K = motor
    lacks = (b.volts - R * b.current - K * b.speed) * np.sign(b.volts)
    driven = np.abs(b.volts) > MISSING * np.abs(b.volts).max()  # a brake lacks nothing
    limited = b.settled & driven & (lacks > MISSING * np.abs(b.volts))
    if limited.sum() < BLOCKS:
        return None
    limit = float(np.median(np.abs(b.current[limited])))
    whole = np.ones(len(b.current), dtype=bool)
    begin = Start((limit,), {"R": R, "K": K, **mechanical(b, K, whole)})
    return _hypothesis(records, limit), begin


def _hypothesis(records: Sequence[MotorRecord], limit_a: float) -> Hypothesis:
    speeds = {id(r): s for r in records if (s := measured_speed(r)) is not None}

    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        """The source gives what this current needs at this speed, and no more."""
        R, _, K = (float(v) for v in record.motor(values)[:3])
        given = record.volts
        way = np.sign(given)
        for_current = (R + record.sensed.series_ohm) * float(size[0])
        most = for_current + np.maximum(way * K * speeds[id(record)], 0.0)
        return changed_voltage(record, values, own, way * np.minimum(np.abs(given), most))

    def words(size: Floats) -> Words:
        return Words(
            "supply",
            f"the motor answers as if the supply gave no more than {size[0]:.3g} A and let its "
            "voltage fall",
            f"{ACTION}; measure the voltage",
        )

    return Hypothesis(
        "supply_limited", effect, ((limit_a,),), (0.02 * limit_a,),
        (0.2 * limit_a,), (3.0 * limit_a,), words,
    )  # fmt: skip
