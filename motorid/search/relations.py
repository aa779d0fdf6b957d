"""What a step response fixes before any search: equations (26), (27), (29) and (30) of the review.

Steady state gives R and B from K. The instant of largest current gives J as well: there
K i = J dω/dt + B ω exactly, with dω/dt **at that instant** (the "exact" rule). The review prints
the largest dω/dt instead, which came earlier: J comes out too small by a fixed amount that no
search can undo (the "printed" rule). Its equation (30) has the sign inverted as well.
Integrated from rest, J ω = K ∫i dt - B ∫ω dt holds at any instant and needs no derivative of a
noisy speed: the "integral" rule takes the instant at half the steady speed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorid.errors import DataError
from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import Record
from motorid.search.bounds import Box

TAIL = 0.1  # steady state: means over the last tenth of the record
INSIDE = 1.0 - 1e-6  # K stays this far below V/ω, where R would be 0

SMOOTH = 10  # the speed at half way is a mean over a fifth of the time it took to get there
NEAR = 0.1  # "J near the rule's": within this part of it (our reading of CSO_m in Tables 8 and 9)

Rule = Literal["printed", "exact", "integral"]


@dataclass(frozen=True)
class StepFacts:
    """Means at steady state, and what holds at the largest current. SI."""

    voltage: float
    current: float
    speed: float
    peak_current: float
    peak_speed: float
    peak_acceleration: float  # dω/dt at the largest current
    largest_acceleration: float  # the largest dω/dt of the record
    half_speed: float  # about half the steady speed
    charge: float  # ∫i dt from rest up to there
    angle: float  # ∫ω dt up to there


def step_facts(record: Record, acceleration: Floats | None = None) -> StepFacts:
    """Read them off a step response with current and speed.

    ``acceleration`` (samples,) is dω/dt where it is known; central differences otherwise.
    Raises DataError if a channel is missing or the motor does not turn at the end.
    """
    if not {"current", "speed"} <= set(record.channels):
        raise DataError("the steady-state relations need a current and a speed channel")
    current, speed = record.measured["current"], record.measured["speed"]
    if acceleration is None:
        acceleration = np.gradient(speed, record.period_s)
    tail = slice(-max(int(TAIL * len(speed)), 1), None)
    voltage, i_ss, w_ss = (float(np.nanmean(y[tail])) for y in (record.input, current, speed))
    if not i_ss * w_ss > 0:
        raise DataError("at the end of the record the motor neither turns nor draws: no step")
    peak = int(np.nanargmax(current))
    half, half_speed = _half_way(speed, w_ss)
    return StepFacts(
        voltage=voltage,
        current=i_ss,
        speed=w_ss,
        peak_current=float(current[peak]),
        peak_speed=float(speed[peak]),
        peak_acceleration=float(acceleration[peak]),
        largest_acceleration=float(np.nanmax(acceleration)),
        half_speed=half_speed,
        charge=_integral(current[: half + 1], record.period_s),
        angle=_integral(speed[: half + 1], record.period_s),
    )


def _half_way(speed: Floats, steady_speed: float) -> tuple[int, float]:
    """Sample at which half the steady speed is passed for good, and the speed there, smoothed."""
    share = speed / steady_speed
    below = np.flatnonzero(share < 0.5)
    rough = int(below[-1]) if len(below) else 0  # noise passes early and often
    width = max(int(np.count_nonzero(share[: rough + 1] < 0.5)) // SMOOTH, 1)
    kernel = np.full(2 * width + 1, 1.0 / (2 * width + 1))
    smooth = np.convolve(share, kernel, mode="same")
    half = max(int(np.argmax(smooth[width:-width] >= 0.5)) + width, width)
    return half, float(smooth[half] * steady_speed)


def _integral(y: Floats, period_s: float) -> float:
    return float(period_s * (np.nansum(y) - 0.5 * (y[0] + y[-1])))


def steady(facts: StepFacts, rule: Rule, values: Floats) -> Floats:
    """Candidates (n, 3) of K, L, J -> (n, 5) of R, L, K, B, J, by (26) and (27)."""
    K, L, J = values.T
    R = (facts.voltage - K * facts.speed) / facts.current
    B = K * facts.current / facts.speed
    return np.column_stack([R, L, K, B, J])


def steady_peak(facts: StepFacts, rule: Rule, values: Floats) -> Floats:
    """Candidates (n, 2) of K, L -> (n, 5): J follows from K by the rule."""
    K, L = values.T
    return steady(facts, rule, np.column_stack([K, L, inertia(facts, rule, K)]))


def steady_near_peak(facts: StepFacts, rule: Rule, values: Floats) -> Floats:
    """Candidates (n, 3) of K, L, s -> (n, 5): J is s times the rule's."""
    K, L, factor = values.T
    return steady(facts, rule, np.column_stack([K, L, factor * inertia(facts, rule, K)]))


def inertia(facts: StepFacts, rule: Rule, K: Floats) -> Floats:
    """J (n,) of K (n,) at the largest current, by one of the three rules."""
    B = K * facts.current / facts.speed
    if rule == "integral":
        return np.asarray((K * facts.charge - B * facts.angle) / facts.half_speed)
    rate = facts.peak_acceleration if rule == "exact" else facts.largest_acceleration
    return np.asarray((K * facts.peak_current - B * facts.peak_speed) / rate)


# What a modified method searches, and how the rest follows.
EXPANSIONS: dict[str, tuple[tuple[str, ...], Callable[[StepFacts, Rule, Floats], Floats]]] = {
    "steady": (("K", "L", "J"), steady),
    "steady+peak": (("K", "L"), steady_peak),
    "steady+near-peak": (("K", "L", "s"), steady_near_peak),
}


def reduced_box(box: Box, facts: StepFacts, names: tuple[str, ...]) -> Box:
    """The bounds of the searched parameters alone, K held below V/ω (R > 0 forces that)."""
    bounds = {
        name: (low, high) for name, low, high in zip(box.names, box.low, box.high, strict=True)
    }
    bounds["s"] = (1.0 - NEAR, 1.0 + NEAR)
    low, high = np.array([bounds[name] for name in names]).T
    k = names.index("K")
    high[k] = min(high[k], INSIDE * facts.voltage / facts.speed)
    return Box(names, low, high, box.log)
