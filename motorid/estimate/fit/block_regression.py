"""The motor's two laws on blocks of a capture, by least squares: before any fit, whatever is wrong.

v = R i + K w        i = (J/K) dw/dt + (B/K) w + (T0/K) sign(w)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Size = tuple[float, ...]  # of a fault

BLOCK = 16  # samples
FEWEST = 8  # blocks that tell anything
TRIMS = 6  # rounds of leaving out
APART = 4.0  # times the median departure: left out


@dataclass(frozen=True)
class Blocks:
    """Means over blocks, all captures in turn, (n,): V, A, rad/s, rad/s².

    ``driven`` throughout; ``settled``: so are both neighbours, under a command of their own.
    """

    volts: Floats
    current: Floats
    speed: Floats
    acceleration: Floats
    driven: Bools
    settled: Bools
    runs: tuple[slice, ...]  # of each capture
    period_s: Floats  # of a block, in each capture


@dataclass(frozen=True)
class Start:
    """Where a fit with a fault begins: the fault's size, and the motor."""

    size: Size
    motor: dict[str, float]


def blocks(records: Sequence[MotorRecord]) -> Blocks | None:
    """The records in blocks; None where one lacks a signed current or the motion."""
    parts = [_of(record) for record in records]
    known = [p for p in parts if p is not None]
    if not known or len(known) < len(records):
        return None
    edges = np.cumsum([0, *(len(p[2]) for p in known)])
    columns = [np.concatenate([p[k] for p in known]) for k in range(6)]
    return Blocks(
        columns[0], columns[1], columns[2], columns[3], columns[4] == 1.0, columns[5] == 1.0,
        tuple(slice(int(a), int(b)) for a, b in pairwise(edges)),
        np.array([BLOCK * r.timeline.period_s for r in records]),
    )  # fmt: skip


def _of(record: MotorRecord) -> tuple[Floats, ...] | None:
    named = {m.block.name: m for m in record.measured}
    moving, current = named.get(POSITION) or named.get(SPEED), named.get(CURRENT)
    count = record.timeline.count // BLOCK - 1
    if current is None or moving is None or current.unsigned or count < FEWEST:
        return None
    place = np.arange(record.timeline.count)
    starts = {u.name: u.start for u in record.unknowns}
    amperes = np.interp(place, current.keep, current.values) - starts.get(CURRENT_OFFSET.name, 0.0)
    y, h = np.interp(place, moving.keep, moving.values), BLOCK * record.timeline.period_s
    edges = place[: count * BLOCK + 1 : BLOCK]
    speed = np.diff(y[edges]) / h if moving.block.name == POSITION else _means(y, count)
    driven = _means(record.driven.astype(np.float64), count)
    settled = (driven == 1.0).astype(np.float64)
    for part in record.timeline.parts:
        near = slice(max(part.start // BLOCK - 1, 0), part.start // BLOCK + 2)
        settled[near] = 0.0
    return (
        _means(record.sensed.volts, count) - record.sensed.series_ohm * _means(amperes, count),
        _means(amperes, count), speed, np.gradient(speed) / h, driven, settled,
    )  # fmt: skip


def _means(values: Floats, count: int) -> Floats:
    return np.asarray(values[: count * BLOCK].reshape(count, BLOCK).mean(axis=1))


def squares(columns: Floats, target: Floats) -> tuple[float, Floats, Floats]:
    """What least squares leaves (a sum), the coefficients (k,), and those over their deviations."""
    scale = np.sqrt((columns**2).sum(axis=0)) + 1e-300
    X = columns / scale
    inverse = np.linalg.pinv(X.T @ X, rcond=1e-12, hermitian=True)
    found = inverse @ (X.T @ target)
    rest = target - X @ found
    left = float(rest @ rest)
    variance = left / max(len(target) - X.shape[1], 1)
    deviations = np.sqrt(np.maximum(np.diag(inverse) * variance, 1e-300))
    return left, found / scale, found / deviations


def electrical(b: Blocks, use: Bools) -> tuple[float, float] | None:
    """R and K of these blocks; None where they do not come out positive."""
    if use.sum() < FEWEST:
        return None
    _, (R, K), _ = squares(np.column_stack([b.current, b.speed])[use], b.volts[use])
    return (float(R), float(K)) if R > 0 and K > 0 else None


def usual(b: Blocks) -> tuple[float, float] | None:
    """R and K of most settled blocks: those that depart from the others are left out."""
    use, motor = b.settled.copy(), electrical(b, b.settled)
    for _ in range(TRIMS):
        if motor is None:
            return None
        off = np.abs(b.volts - motor[0] * b.current - motor[1] * b.speed)
        use = b.settled & (off <= APART * float(np.median(off[b.settled])))
        motor = electrical(b, use)
    return motor


def mechanical(b: Blocks, K: float, use: Bools) -> dict[str, float]:
    """J, B and T0 of these blocks, not below 0, for a known K."""
    _, found, _ = squares(friction_columns(b)[use], b.current[use])
    return {n: max(K * float(x), 0.0) for n, x in zip(("J", "B", "T0"), found, strict=True)}


def friction_columns(b: Blocks) -> Floats:
    """(n, 3): what the current of the mechanical law is made of."""
    return np.column_stack([b.acceleration, b.speed, np.sign(b.speed)])
