"""What follows an inductance that is hardly told, and follows it by no straight line.

Rows that are longer than L/R tell an inductance, a lag and an inertia apart by little. Beside a
large inductance the inertia is as good as known; beside a small one it is another. The covariance
at the estimate knows the first alone. So the inductance is held at either end of its own interval,
everything else is made most likely again, and what moved by more than a straight line foretells
counts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Solution
from motorid.estimate.solver.search_coordinates import Coordinates
from motorid.estimate.uncertainty import added_noise
from motorid.estimate.uncertainty.covariance import NOISE, Statistical, covariance_of
from motorid.estimate.uncertainty.intervals import student
from motorid.estimate.uncertainty.profile_likelihood import Profile

Floats = NDArray[np.float64]

BENT = {"L": 0.3}  # standard deviation of a logarithm, from which others follow by no straight line
FARTHEST = 3.0  # of a logarithm, that an end is looked for at first
NEAREST = 2.0  # times as much: from there on an inductance is none


class _Fair(Profile):
    """A profile less what noise of the voltage leaves of the objective."""

    def fall(self, found: Solution) -> float:
        """An inductance passes less of it than none does."""
        return added_noise.judged(self.records, found).fair - self._fair

    @cached_property
    def _fair(self) -> float:
        return added_noise.judged(self.records, self.solution).fair


def shifts(
    solution: Solution, records: Sequence[MotorRecord], statistical: Statistical
) -> list[Floats]:
    """Of the parameters (p,) in search coordinates, by one standard deviation of each such value,
    beyond what the covariance has of it.
    """
    each = zip(solution.unknowns, statistical.deviations.tolist(), strict=True)
    bent = [k for k, (u, size) in enumerate(each) if u.log and size > BENT.get(u.name, np.inf)]
    return [shift for k in bent if (shift := _shift(solution, records, k, statistical)).any()]


def _shift(
    solution: Solution, records: Sequence[MotorRecord], place: int, statistical: Statistical
) -> Floats:
    """The larger one of both ends', in standard deviations of all parameters together."""
    deviations = np.maximum(statistical.deviations, np.finfo(np.float64).tiny)
    straight = statistical.covariance[place] / deviations[place]
    found = [np.zeros(len(deviations))]
    for moved in _moved(solution, records, place, statistical):
        beyond = np.sqrt(np.maximum(moved**2 - straight**2, 0.0))
        beyond[place] = 0.0
        found.append(np.copysign(beyond, moved))
    return max(found, key=lambda shift: float(np.sum((shift / deviations) ** 2)))


def _moved(
    solution: Solution, records: Sequence[MotorRecord], place: int, statistical: Statistical
) -> Iterator[Floats]:
    """(p,) by which parameters move on the way to either end, for one of its standard deviations.

    An end that no motor with finite readings has is none.
    """
    profile = _Fair(solution, records, place)
    factor = student(float(statistical.freedom[place]))
    white = float(covariance_of(solution.information)[place, place])
    variance = max(float(statistical.lines[NOISE][place]), white)
    wanted = factor * math.sqrt(variance / white)
    reach = min(factor * math.sqrt(variance), FARTHEST)
    frame = Coordinates(solution.unknowns)
    least = profile.best * math.exp(-FARTHEST * NEAREST)
    for first in (profile.best * math.exp(-reach), profile.best * math.exp(reach)):
        try:
            values = profile.held(profile.end(first, wanted, least)).values
        except DataError:
            continue
        yield (frame.inward(values) - frame.inward(solution.values)) / factor
