"""[12]'s two routes on a record of voltage levels and a coast: equations (11) and (12).

(11) is a solve for two levels; over more it is the least squares that the review calls it. It is
singular without Coulomb friction, and (12) holds with the bridge open only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motorid.errors import DataError
from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import Record

SETTLED = 0.4  # the part of each level, at its end, that counts as steady
INTERVAL = (0.1, 0.9)  # of the level's rise: where the acceleration is taken
STILL = 0.05  # of the first speed: below it a coast is over


@dataclass(frozen=True)
class Levels:
    """Means at each steady level, shapes (m,), SI."""

    voltage: Floats
    current: Floats
    speed: Floats


def edges(record: Record) -> tuple[tuple[int, int], ...]:
    """Stretches of constant input with the bridge closed: first sample, end."""
    is_open = np.zeros(len(record.input), bool) if record.open is None else record.open
    changes = np.flatnonzero(np.diff(record.input) != 0.0) + 1
    opened = np.flatnonzero(np.diff(is_open.astype(int)) != 0) + 1
    marks = sorted({0, *changes.tolist(), *opened.tolist(), len(record.input)})
    return tuple((a, b) for a, b in pairwise(marks) if not is_open[a])


def levels(record: Record) -> Levels:
    """Means over the end of each stretch of constant input."""
    tails = [slice(b - max(int(SETTLED * (b - a)), 1), b) for a, b in edges(record)]
    signals = record.input, record.measured["current"], record.measured["speed"]
    return Levels(*(np.array([np.nanmean(y[tail]) for tail in tails]) for y in signals))


def steady_state(at: Levels) -> dict[str, float]:
    """R, K, B, T0 by equation (11) over all levels: one linear least squares.

    Raises DataError below two levels.
    """
    if len(at.voltage) < 2:
        raise DataError("equation 11 needs two voltage levels at least: the data hold one")
    zero, one = np.zeros(len(at.voltage)), np.ones(len(at.voltage))
    electrical = np.column_stack([at.current, at.speed, zero, zero])
    mechanical = np.column_stack([zero, at.current, -at.speed, -one])
    # volts and amperes are made comparable, so that neither equation rules the other
    weight = np.abs(at.voltage).max() / np.abs(at.current).max()
    size = np.array([1.0, 1.0, 1.0 / np.abs(at.speed).max(), 1.0])
    matrix = np.vstack([electrical, weight * mechanical])
    right = np.concatenate([at.voltage, zero])
    R, K, B, T0 = np.linalg.lstsq(matrix * size, right, rcond=None)[0] * size
    return {"R": float(R), "K": float(K), "B": float(B), "T0": float(T0)}


def two_levels(at: Levels, R: float) -> dict[str, float]:
    """K over all levels with R known, B and T0 from the slowest and the fastest."""
    K = float(np.mean((at.voltage - R * at.current) / at.speed))
    slow, fast = int(np.argmin(at.speed)), int(np.argmax(at.speed))
    B = float(K * (at.current[fast] - at.current[slow]) / (at.speed[fast] - at.speed[slow]))
    return {"K": K, "B": B, "T0": float(K * at.current[slow] - B * at.speed[slow])}


def coast_inertia(speed: Floats, period_s: float, viscous: float, coulomb: float) -> float:
    """J by equation (12) integrated: J (ω - ω0) = -B ∫ω dt - T0 t, while the rotor turns."""
    turning = int(np.argmax(speed < STILL * speed[0])) or len(speed)
    speed = speed[:turning]
    time = period_s * np.arange(len(speed))
    steps = 0.5 * period_s * (speed[1:] + speed[:-1])
    lost = viscous * np.concatenate([[0.0], np.cumsum(steps)]) + coulomb * time
    # a free ω0: the first reading is as noisy as any other
    slope, _ = np.linalg.lstsq(np.column_stack([-lost, np.ones(len(lost))]), speed, rcond=None)[0]
    return float(1.0 / slope)


def rise_inertia(
    current: Floats, speed: Floats, period_s: float, friction: Mapping[str, float], top: float
) -> float:
    """J from the impulse over 10 to 90 % of a rise to the speed ``top``.

    ``friction`` holds K, B and T0. Raises DataError where the rise holds under two samples.
    """
    low, high = (part * top for part in INTERVAL)
    inside = np.flatnonzero((speed > low) & (speed < high))
    if len(inside) < 2:
        raise DataError("the motor accelerates too fast for its samples: sample faster")
    first, last = int(inside[0]), int(inside[-1])
    torque = friction["K"] * current - friction["B"] * speed - friction["T0"]
    impulse = period_s * (torque[first:last].sum() + 0.5 * (torque[last] - torque[first]))
    return float(impulse / (speed[last] - speed[first]))


def acceleration(record: Record) -> dict[str, float]:
    """The acceleration method on a record: R by (11), J over the first rise."""
    at = levels(record)
    R = steady_state(at)["R"]
    friction = two_levels(at, R)
    rise = slice(*edges(record)[0])
    current, speed = record.measured["current"][rise], record.measured["speed"][rise]
    J = rise_inertia(current, speed, record.period_s, friction, float(at.speed[0]))
    return {"R": R, **friction, "J": J}


def least_squares(record: Record) -> dict[str, float]:
    """R, K, B, T0 by (11) and J by (12). Raises DataError without a coast."""
    if record.open is None or not record.open.any():
        raise DataError("equation 12 needs a coast with the bridge open: the record holds none")
    found = steady_state(levels(record))
    speed = record.measured["speed"][record.open]
    return {**found, "J": coast_inertia(speed, record.period_s, found["B"], found["T0"])}
