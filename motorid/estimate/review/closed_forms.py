"""[12]'s two routes on a record of voltage levels and a coast: equations (11) and (12).

(11) is a solve for two levels; over more it is the least squares that the review calls it. It is
singular without Coulomb friction, and (12) holds with the bridge open only.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motorid.errors import DataError
from motorid.estimate.types import Floats
from motorid.motor.batch import Record

SETTLED = 0.4  # the part of each level, at its end, that counts as steady
INTERVAL = (0.1, 0.9)  # of the level's rise: where the acceleration is taken


@dataclass(frozen=True)
class Levels:
    """Means at each steady level, shapes (m,), SI, and where each level begins and ends."""

    voltage: Floats
    current: Floats
    speed: Floats
    edges: tuple[tuple[int, int], ...]


def levels(record: Record) -> Levels:
    """Stretches of constant input with the bridge closed. Raises DataError below two."""
    is_open = np.zeros(len(record.input), bool) if record.open is None else record.open
    changes = np.flatnonzero(np.diff(record.input) != 0.0) + 1
    opened = np.flatnonzero(np.diff(is_open.astype(int)) != 0) + 1
    marks = sorted({0, *changes.tolist(), *opened.tolist(), len(record.input)})
    edges = tuple((a, b) for a, b in pairwise(marks) if not is_open[a])
    if len(edges) < 2:
        raise DataError("equation 11 needs two voltage levels at least: the record holds one")
    tails = [slice(b - max(int(SETTLED * (b - a)), 1), b) for a, b in edges]
    current, speed = record.measured["current"], record.measured["speed"]
    means = [
        np.array([np.nanmean(y[tail]) for tail in tails]) for y in (record.input, current, speed)
    ]
    return Levels(means[0], means[1], means[2], edges)


def steady_state(at: Levels) -> dict[str, float]:
    """R, K, B, T0 by equation (11) over all levels: one linear least squares."""
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


def coast_down(record: Record, viscous: float, coulomb: float) -> dict[str, float]:
    """J by equation (12) integrated: J (ω - ω0) = -B ∫ω dt - T0 t, while the rotor turns."""
    if record.open is None or not record.open.any():
        raise DataError("equation 12 needs a coast with the bridge open: the record holds none")
    speed = record.measured["speed"][record.open]
    turning = int(np.argmax(speed < 0.05 * speed[0])) or len(speed)
    speed = speed[:turning]
    time = record.period_s * np.arange(len(speed))
    steps = 0.5 * record.period_s * (speed[1:] + speed[:-1])
    angle = np.concatenate([[0.0], np.cumsum(steps)])
    lost = viscous * angle + coulomb * time
    # a free ω0: the first reading is as noisy as any other
    slope, _ = np.linalg.lstsq(np.column_stack([-lost, np.ones(len(lost))]), speed, rcond=None)[0]
    return {"J": float(1.0 / slope)}


def acceleration(record: Record) -> dict[str, float]:
    """K, T0, B from the first and last level, R over all, J over 10 to 90 % of the first rise."""
    at = levels(record)
    R = steady_state(at)["R"]
    K = float(np.mean((at.voltage - R * at.current) / at.speed))
    B = float(K * (at.current[-1] - at.current[0]) / (at.speed[-1] - at.speed[0]))
    T0 = float(K * at.current[0] - B * at.speed[0])
    current, speed = record.measured["current"], record.measured["speed"]
    begin, end = at.edges[0]
    low, high = (part * at.speed[0] for part in INTERVAL)
    inside = np.flatnonzero((speed[begin:end] > low) & (speed[begin:end] < high)) + begin
    first, last = int(inside[0]), int(inside[-1])
    torque = K * current - B * speed - T0
    impulse = record.period_s * (torque[first:last].sum() + 0.5 * (torque[last] - torque[first]))
    return {"R": R, "K": K, "B": B, "J": float(impulse / (speed[last] - speed[first])), "T0": T0}


def least_squares(record: Record) -> dict[str, float]:
    """R, K, B, T0 by (11) and J by (12)."""
    found = steady_state(levels(record))
    return {**found, **coast_down(record, found["B"], found["T0"])}
