"""The fit again with a fault's size as one more unknown, which confirms a suspicion or not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.estimate.diagnosis import misfit
from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.fit.block_regression import Size
from motorid.estimate.fit.start_values import start_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.concentrated_likelihood import BEYOND
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution, Unknown

Floats = NDArray[np.float64]

STEPS = 20
VANISHED, AGAIN = 0.05, 0.3  # L/R in sample periods


class Widened:
    """A record whose last shared unknowns are the size of a fault. Its noise is taken as white."""

    def __init__(self, record: MotorRecord, own: Floats, hypothesis: Hypothesis | None) -> None:
        self.record, self.hypothesis = record, hypothesis
        self.unknowns = tuple(
            replace(u, start=float(x)) for u, x in zip(record.unknowns, own, strict=True)
        )
        self.blocks = tuple(m.block for m in record.measured)

    @property
    def simulated(self) -> int:
        """Responses of the record so far."""
        return self.record.simulated

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less fitted less what the fault does, weighed; one array per block."""
        if self.hypothesis is None:
            return self.record.weighed(self.record.departures(shared, own), filtered=False)
        p = len(shared) - len(self.hypothesis.scale)
        left = self.record.departures(shared[:p], own)
        moved = self.hypothesis.effect(self.record, shared[:p], own, shared[p:])
        parts = [a - b for a, b in zip(left, moved, strict=True)]
        return self.record.weighed(parts, filtered=False)

    def foresee(self, points: Sequence[tuple[Floats, Floats]]) -> None:
        """The record's responses at these points come next."""
        p = -len(self.hypothesis.scale) if self.hypothesis is not None else None
        self.record.foresee([(shared[:p], own) for shared, own in points])


@dataclass(frozen=True)
class Refit:
    """``values`` of the motor and ``size`` of the fault that fit best, and F there."""

    values: Floats
    size: Floats
    objective: float
    search: Solution


def refit(
    records: Sequence[MotorRecord],
    starts: Sequence[Solution],
    hypothesis: Hypothesis | None = None,
    size: Size = (),
    enough: float = 1.0,
    steps: int = STEPS,
) -> Refit:
    """The most likely motor and size, the best from all ``starts``; without a hypothesis, of six.

    A fit ends when F would fall by less than ``enough``, or after so many ``steps``. Where no motor
    with finite readings is, F is infinite. Raises DataError where a motor without a fault is there.
    """
    found = [_from(records, start, hypothesis, size, enough, steps) for start in starts]
    best = min(found, key=lambda f: f.objective)
    if hypothesis is None and not math.isfinite(best.objective):
        raise DataError(BEYOND)
    return best


def residuals(
    records: Sequence[MotorRecord], found: Refit, hypothesis: Hypothesis
) -> list[list[Floats]]:
    """What a fit with a fault leaves of every record, by channel; weighed, in SI units."""
    search = found.search
    each = zip(records, search.own, strict=True)
    return [Widened(r, own, hypothesis).residuals(search.values, own) for r, own in each]


def rest(
    records: Sequence[MotorRecord], found: Refit, hypothesis: Hypothesis
) -> tuple[float, float]:
    """The excess that a fit with a fault leaves beyond what chance gives the fault itself; and how
    much of it that is.
    """
    if not math.isfinite(found.objective):
        return math.inf, 0.0
    more = scatter(records, found.values, found.search.own, hypothesis, found.size)
    left = residuals(records, found, hypothesis)
    beyond = misfit.excess(records, left, more)
    return beyond, misfit.excess(records, left) - beyond if more else 0.0


def scatter(
    records: Sequence[MotorRecord],
    values: Floats,
    own: Sequence[Floats],
    hypothesis: Hypothesis,
    size: Floats,
) -> list[list[float]]:
    """Variance (SI) by record and channel, as weighed, that chance gives a fault of a size."""
    if hypothesis.scatter is None:
        return []
    return [
        [
            float(np.mean(v if m.root_weights is None else v * m.root_weights**2))
            for m, v in zip(r.measured, hypothesis.scatter(r, values, o, size), strict=True)
        ]
        for r, o in zip(records, own, strict=True)
    ]


def plain(records: Sequence[MotorRecord], solution: Solution) -> Solution:
    """The derivatives at ``solution`` in white noise: what a fit weighs down is seen again."""
    shared = [
        replace(u, start=float(v), log=u.log or (u.lower == 0.0 and v > 0))
        for u, v in zip(solution.unknowns, solution.values, strict=True)
    ]
    widened = [Widened(r, own, None) for r, own in zip(records, solution.own, strict=True)]
    return maximise(shared, widened, max_iterations=0)


def _from(
    records: Sequence[MotorRecord],
    start: Solution,
    hypothesis: Hypothesis | None,
    size: Size,
    enough: float,
    steps: int,
) -> Refit:
    shared = [replace(u, start=float(v)) for u, v in zip(start.unknowns, start.values, strict=True)]
    more = []
    if hypothesis is not None:
        h = hypothesis
        bounds = zip(size, h.scale, h.lower, h.upper, strict=True)
        more = [Unknown(f"size {k}", a, b, c, scale=s) for k, (a, s, b, c) in enumerate(bounds)]
        if h.place is not None:  # between two levels nothing tells where it is
            more[1:] = [replace(u, lower=u.start, upper=u.start) for u in more[1:]]
    widened = [Widened(r, own, hypothesis) for r, own in zip(records, start.own, strict=True)]
    p = len(shared)
    try:
        found = maximise([*shared, *more], widened, max_iterations=steps, enough=enough)
    except DataError:
        return Refit(start.values, np.array(size, dtype=float), math.inf, start)
    return Refit(found.values[:p], found.values[p:], found.objective, found)


def go_on(
    records: Sequence[MotorRecord],
    start: Solution,
    hypothesis: Hypothesis,
    begun: Refit,
    enough: float,
) -> Refit:
    """The same from where a fit after few steps was; ``start``: that one's."""
    there = replace(start, values=begun.values, own=begun.search.own)
    return _from(records, there, hypothesis, tuple(begun.size.tolist()), enough, STEPS)


def starts(records: Sequence[MotorRecord], solution: Solution) -> list[Solution]:
    """Where fits begin: the solution, and the closed forms, which a fault misleads less."""
    free = {u.name for u in solution.unknowns}
    fixed = {
        name: float(value)
        for name, value in zip(records[0].names, records[0].motor(solution.values), strict=True)
        if name not in free
    }
    period = min(r.timeline.period_s for r in records)
    try:
        closed = start_values(records, fixed)
    except DataError:  # the closed forms need a current and a motion
        return [at(solution, {}, period)]
    return [at(solution, {}, period), at(solution, closed, period)]


def at(solution: Solution, motor: Mapping[str, float], period_s: float) -> Solution:
    """The same with the motor's values in place of the solution's.

    An inductance that has all but vanished gets one that the data can tell: no fit finds back.
    """
    values = {u.name: float(v) for u, v in zip(solution.unknowns, solution.values, strict=True)}
    values |= {name: v for name, v in motor.items() if name in values and v > 0}
    if "L" in values and "R" in values and values["L"] < VANISHED * values["R"] * period_s:
        values["L"] = AGAIN * values["R"] * period_s
    return replace(solution, values=np.array([values[u.name] for u in solution.unknowns]))
