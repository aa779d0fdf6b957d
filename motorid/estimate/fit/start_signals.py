"""The signals of a record by which a search begins: whole, on its grid, without offsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.errors import DataError
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.standstill import STIR

Floats = NDArray[np.float64]

SHORTED = 0.02  # of the highest voltage: less is a brake's
TURNED = 16  # samples over which an angle shows the way of its motion
FLIPS = 50  # between two counts: a sensor that steps once or twice shows no mean
PARTS = 16  # of a record, whose mean speeds are compared
CHANCE = 8.0  # standard deviations of such a mean, by which they differ of a motor that moves


@dataclass(frozen=True)
class Signals:
    """A record's readings on its grid, offsets at rest removed: V, A, rad, rad/s; all (count,)."""

    period_s: float
    volts: Floats
    current: Floats
    angle: Floats
    speed: Floats | None  # where it was measured itself
    edges: tuple[int, ...]  # first intervals of the program's parts, and the end
    open: tuple[bool, ...]
    series_ohm: float
    step_rad: float = 0.0  # of the angle, as it was counted; 0: it was not


def signals(record: MotorRecord, others: Sequence[MotorRecord] = ()) -> Signals:
    """The record's readings made whole. Raises DataError when it lacks current or motion, or one
    never changes; of a piece of a log another piece among the ``others`` may have the change.
    """
    line = record.timeline
    named = {m.block.name: m for m in record.measured}
    _insist(record, set(named), others)
    grid: dict[str, Floats] = {}
    for name, m in named.items():
        grid[name] = np.interp(np.arange(line.count), m.keep, m.values)
    starts = {u.name: u.start for u in record.unknowns}
    amperes = grid[CURRENT] - starts.get(CURRENT_OFFSET.name, 0.0)
    speed = grid.get(SPEED) if POSITION not in named else None
    angle = grid[POSITION] if POSITION in named else np.cumsum(grid[SPEED]) * line.period_s
    if named[CURRENT].unsigned:
        amperes = amperes * _sign(record.sensed.volts, angle)
    amperes = np.where(record.driven, amperes, 0.0)
    return Signals(
        line.period_s,
        np.where(record.driven, record.sensed.volts, 0.0),
        amperes,
        angle,
        speed,
        (*(p.start for p in line.parts), line.count),
        tuple(p.open for p in line.parts),
        record.sensed.series_ohm,
        named[POSITION].resolution if POSITION in named else 0.0,
    )


def _sign(volts: Floats, angle: Floats) -> Floats:
    """Of a current (n,), near enough for a start: its voltage's; in a brake against the motion."""
    width = min(TURNED, len(angle) - 1)
    turned = angle[np.minimum(np.arange(len(angle)) + width, len(angle) - 1)] - angle
    braked = np.abs(volts) < SHORTED * float(np.abs(volts).max(initial=0.0))
    return np.asarray(np.where(braked, -np.sign(turned), np.sign(volts)))


def _insist(record: MotorRecord, named: set[str], others: Sequence[MotorRecord]) -> None:
    """Raises DataError when the current or the motion is missing, unusable, or never changes."""
    pieces = [record, *(other for other in others if _of_one_log(record, other))]
    where = f" in {record.capture.path}" if record.capture.path else ""
    for names, what in (((CURRENT,), "current"), ((POSITION, SPEED), "position or speed")):
        if not named & set(names):
            given = any(record.capture.get(name) is not None for name in names)
            why = (
                "no usable reading (missing, or at the end of the range)" if given else "no channel"
            )
            raise DataError(
                f"there is {why} of the {what}{where}: the fit of all six parameters needs "
                "voltage, current and motion"
            )
        used = next(name for name in names if name in named)
        if not any(_changes(piece, used) for piece in pieces):
            raise DataError(
                f"the {used} never changes{where}: check its sensor, and that the motor moves"
            )


def _of_one_log(record: MotorRecord, other: MotorRecord) -> bool:
    logs = record.sensed.waveform is not None and other.sensed.waveform is not None
    return logs and record.capture.path == other.capture.path


def _changes(record: MotorRecord, name: str) -> bool:
    m = next((m for m in record.measured if m.block.name == name), None)
    if m is None:
        return False
    return float(np.ptp(m.values)) > STIR * m.resolution or (name == SPEED and _wanders(m.values))


def _wanders(speeds: Floats) -> bool:
    """Their mean moves by more than chance: each (n,) shows a count or none, of a slow shaft."""
    parts = np.array_split(speeds, PARTS)
    chance = np.sqrt(float(np.mean([np.var(part) for part in parts])) * PARTS / len(speeds))
    moves = float(np.ptp([np.mean(part) for part in parts])) > CHANCE * chance
    return moves and int(np.count_nonzero(np.diff(speeds))) > FLIPS
