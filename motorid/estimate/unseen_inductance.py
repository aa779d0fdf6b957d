"""An inductance that no reading shows: what PWM does with it tells it.

Where L/R is far below a sample and the current is a mean over whole PWM periods, no reading shows
how a current rises. How far it swings within those periods still depends on L, and with that what
brushes and dead time take. Judged by the search's own last answer, a wrong L brings a wrong loss,
and that an L which is worse: the search runs off, and takes friction with it. So one inductance
after the other is held, what drives the motor is judged by it, and the likeliest is taken. With
diode decay the size of the pulses tells it (pulses.py). How well either is foretold bounds it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motorid.capture.model import Capture
from motorid.estimate import pulses
from motorid.estimate.clusters import by_part
from motorid.estimate.foretold import Foretold
from motorid.estimate.passes import judge_at, with_sources
from motorid.estimate.record import MotorRecord
from motorid.estimate.settling import vanished, whitened, with_delays
from motorid.estimate.solution import Solution
from motorid.estimate.uncertainty import statistical
from motorid.estimate.unknowns import merged

Fitted = tuple[list[MotorRecord], Solution]

UNSEEN = 0.1  # standard deviation of the logarithm of an inductance that readings hardly tell
WHITE = 0.1  # of that: the least of white noise, from which correlated noise may be as much
BY_RIPPLE, BY_PULSES = 0.08, 0.04  # the same of one that these tell
BETTER = 0.5  # of their standard deviation: what readings tell that well they should not lose
LARGEST, SMALLEST, FACTOR = 2.0, 0.01, 1.6  # of those held: L/R in sample periods
CLEAR = 100.0  # of chi-square, by which a next one is worse than the likeliest
CLOSE = 0.04  # logarithm: near enough to the likeliest
KEPT = 0.3  # logarithm, by which a search may depart from it


def told(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    fixed: Mapping[str, float],
    known: Mapping[str, float],
    seen: Solution,
) -> Fitted | None:
    """Other records of the same captures, and their solution with an inductance that ``seen``, at
    ``known`` values, hardly tells; None where it does, or where neither ripple nor pulses can.
    """
    if _unsure(seen, records) < UNSEEN:
        return None
    search = _Search([record.capture for record in records], free, fixed, known, seen)
    inductance_h, by = pulses.inductance(records, seen), BY_PULSES
    if not inductance_h and all(record.ripples for record in records):
        inductance_h, by = search.by_ripple(), BY_RIPPLE
    return search.ended(inductance_h, by) if inductance_h else None


def _unsure(solution: Solution, records: Sequence[MotorRecord]) -> float:
    """Standard deviation of the logarithm of the inductance, as far as it matters; 0: held."""
    if all(unknown.name != "L" for unknown in solution.unknowns):
        return 0.0
    k = _place(solution)
    if solution.at_bound[k] or vanished(solution, records):
        return math.inf
    white = math.sqrt(max(float(solution.covariance[k, k]), 0.0))
    return white if white < WHITE * UNSEEN else _deviation(solution, records)


@dataclass(frozen=True)
class _Search:
    """Fits of ``captures`` with one inductance after the other, all from ``known`` values.

    ``near`` is a solution with those values.
    """

    captures: Sequence[Capture]
    free: Sequence[str]
    fixed: Mapping[str, float]
    known: Mapping[str, float]
    near: Solution

    def held(self, inductance_h: float) -> Fitted:
        """With that one."""
        records = [MotorRecord(capture, self.free, self.fixed) for capture in self.captures]
        judge_at(records, self.near, inductance_h)
        known = {**self.known, "L": inductance_h}
        return records, with_sources(records, self.free, known, inductance_h)

    def by_ripple(self) -> float | None:
        """H of the likeliest where others are clearly less likely."""

        def worse(log_h: float) -> float:
            return self.held(math.exp(log_h))[1].objective

        tau = self.known["R"] * min(capture.period_s for capture in self.captures)
        count = math.ceil(math.log(LARGEST / SMALLEST, FACTOR))
        logs = math.log(tau * LARGEST) - math.log(FACTOR) * np.arange(count)
        found = [worse(log_h) for log_h in logs]
        k = int(np.argmin(found))
        if k in (0, count - 1) or min(found[k - 1], found[k + 1]) < found[k] + CLEAR:
            return None
        from scipy.optimize import minimize_scalar  # rarely needed, and slow to load

        ends = float(logs[k + 1]), float(logs[k - 1])
        best = minimize_scalar(worse, bounds=ends, method="bounded", options={"xatol": CLOSE})
        return math.exp(float(best.x))

    def ended(self, inductance_h: float, unsure: float) -> Fitted | None:
        """With an inductance known to ``unsure`` of itself, or better if its readings tell it.

        None where they would tell it better, if it were that, but do not.
        """
        records, held = self.held(inductance_h)
        would_tell = _deviation(held, records)
        alone = self.finished(records, held)
        if _stays(alone, held, _deviation(alone, records), unsure):
            return records, alone
        if would_tell < BETTER * unsure:
            return None
        _, larger = self.held(inductance_h * math.exp(unsure))
        records, held = self.held(inductance_h)
        for record in records:
            record.foretold = Foretold(inductance_h, _shift(held, larger))
        return records, self.finished(records, held)

    def finished(self, records: Sequence[MotorRecord], held: Solution) -> Solution:
        """From a held one to an end like that of any other fit."""
        start = merged(self.known, held)
        solution = with_sources(records, self.free, start)
        solution = with_delays(records, self.free, start, solution)
        return whitened(records, self.free, merged(start, solution), solution)


def _stays(alone: Solution, held: Solution, deviation: float, unsure: float) -> bool:
    """The search keeps to what it was given, and its readings tell it better."""
    k = _place(alone)
    moved = math.log(float(alone.values[k] / held.values[k]))
    return not alone.at_bound[k] and abs(moved) < KEPT and deviation < unsure


def _place(solution: Solution) -> int:
    return [unknown.name for unknown in solution.unknowns].index("L")


def _deviation(solution: Solution, records: Sequence[MotorRecord]) -> float:
    """Of the logarithm of the inductance, whatever the noise, with the spread of the parts."""
    spread = statistical(solution, parts=by_part(solution, records))
    return float(spread.deviations[_place(solution)])


def _shift(held: Solution, larger: Solution) -> dict[str, float]:
    """By name, of search coordinates."""
    each = zip(held.unknowns, held.values, larger.values, strict=True)
    return {
        u.name: math.log(float(b / a)) if u.log and a > 0 and b > 0 else float(b - a)
        for u, a, b in each
    }
