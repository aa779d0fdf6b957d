"""Intervals by the likelihood's own profile, where a parabola is a poor likeness of it.

Friction near nothing and an inductance hardly told have likelihoods that lean: beside the estimate
one side is steeper than the other, or ends at 0. There a value is held, everything else is made
most likely again, and the interval ends where the likelihood has fallen as far as the covariance
would have it fall at its own ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.errors import DataError
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import Statistical, covariance_of
from motorid.estimate.uncertainty.intervals import UNKNOWN, student, torque_is_lost

LEANS = {"B": 0.4, "T0": 0.4, "L": 0.12}  # standard deviation over value, from which it may
FRICTION = ("B", "T0")
STEPS = 5  # fits at most for one end
NEAR = 0.03  # of the wanted root of the fall
FARTHEST = 4.0  # times the parabola's own end


@dataclass(frozen=True)
class Profile:
    """The objective over values of one parameter, everything else most likely."""

    solution: Solution
    records: Sequence[MotorRecord]
    place: int

    @property
    def best(self) -> float:
        """The estimate."""
        return float(self.solution.values[self.place])

    def held(self, value: float) -> Solution:
        """The most likely everything else where the parameter has that value.

        Raises DataError where no finite motor remains.
        """
        pairs = zip(self.solution.unknowns, self.solution.values.tolist(), strict=True)
        held = [replace(unknown, start=start) for unknown, start in pairs]
        held[self.place] = replace(held[self.place], start=value, lower=value, upper=value)
        return maximise(held, self.records, before=self.solution)

    def root(self, value: float) -> float:
        """Root of how far the likelihood falls when the parameter is held there; infinite where no
        finite motor remains.
        """
        try:
            found = self.held(value)
        except DataError:
            return math.inf
        return math.sqrt(max(self.fall(found), 0.0))

    def fall(self, found: Solution) -> float:
        """Of the likelihood, in chi-square, from the estimate to what was found elsewhere."""
        return found.objective - self.solution.objective

    def end(self, first: float, wanted: float, least: float = 0.0) -> float:
        """Where the root of the fall is ``wanted``, from ``first`` on; no less than ``least``.

        It may rise at once, where another parameter comes to its bound: what is known of either
        side brackets it, and the far side of the bracket is the end where no fit comes near.
        """
        value, farthest = first, FARTHEST * (first - self.best)
        inside, beyond = self.best, None
        for _ in range(STEPS):
            value = max(value, least)
            fallen = self.root(value)
            if value == least and fallen < wanted:
                return least
            if abs(fallen - wanted) < NEAR * wanted:
                return value
            inside, beyond = (value, beyond) if fallen < wanted else (inside, value)
            reach = (value - self.best) * wanted / max(fallen, 0.05 * wanted)
            value = self.best + math.copysign(min(abs(reach), abs(farthest)), reach)
            if beyond is not None and not min(inside, beyond) < value < max(inside, beyond):
                value = (inside + beyond) / 2.0
        return max(value if beyond is None else beyond, least)


def intervals(
    solution: Solution, records: Sequence[MotorRecord], statistical: Statistical
) -> dict[str, tuple[float, float]]:
    """Ends (SI) of the statistical 95 % interval of every parameter whose likelihood may lean."""
    white = np.sqrt(np.diag(covariance_of(solution.information)))
    found = {}
    one_sided = bool(solution.at_bound.any())
    lost = FRICTION if torque_is_lost(solution, statistical) else ()
    for k, unknown in enumerate(solution.unknowns):
        if unknown.name in lost:
            continue
        value, deviation = float(solution.values[k]), float(statistical.deviations[k])
        size = 1.0 if unknown.log else value
        leans = deviation > LEANS.get(unknown.name, np.inf) * size
        leans |= one_sided and unknown.name in FRICTION  # what one cannot be the other has to
        if leans and not _lost(deviation, unknown.log):
            reach = student(float(statistical.freedom[k])) * deviation
            found[unknown.name] = interval(solution, records, k, reach, float(white[k]))
    return found


def _lost(deviation: float, log: bool) -> bool:
    """So uncertain that no interval is given."""
    return log and deviation > UNKNOWN


def interval(
    solution: Solution, records: Sequence[MotorRecord], place: int, reach: float, white: float
) -> tuple[float, float]:
    """Ends (SI) of one parameter's interval.

    ``reach`` is the half-width that the covariance gives, ``white`` the standard deviation that
    white noise alone would, both in search coordinates: their ratio says how far the likelihood is
    to fall.
    """
    profile, wanted = Profile(solution, records, place), reach / white
    if solution.unknowns[place].log:
        factor = math.exp(reach)
        low = profile.end(profile.best / factor, wanted, least=profile.best / factor**FARTHEST)
        return low, profile.end(profile.best * factor, wanted)
    low = profile.end(profile.best - reach, wanted) if profile.best > 0 else 0.0
    return low, profile.end(profile.best + reach, wanted)
