"""Whether captures agree: how well each is foretold by the others, by straight lines.

A capture that was left out is held against the answer of the others, and that answer may move as
far as they leave it open. So what few of them can tell counts for little, and the sum over captures
is the gain of all together, less what the others give up for each.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.problem import Solution, bounded_inverse
from motorid.estimate.solver.search_coordinates import Coordinates

Floats = NDArray[np.float64]


def foretold(gain: float, wider: Solution, narrower: Solution) -> float:
    """The gain of the wider answer on captures left out, each in turn; ``gain``: on all of them."""
    return gain - given_up(wider) + given_up(narrower)


def given_up(solution: Solution) -> float:
    """How much likelier (F) captures are at an answer of their own than at the common one.

    For each capture that is left out in turn, by one Newton step of the others; summed.
    """
    tables = [(line.orthogonal.T, line.residual) for line in solution.records]
    informations = [gram(columns, columns) for columns, _ in tables]
    slopes = [project(columns, left) for columns, left in tables]
    rest = _towards_the_top(solution, np.sum(slopes, axis=0))
    total = 0.0
    for own, slope in zip(informations, slopes, strict=True):
        pull = slope - own @ rest  # of this capture, where all together are likeliest
        others = bounded_inverse(solution.information - own, solution.at_bound)
        total += float(pull @ others @ pull)
    return total


def _towards_the_top(solution: Solution, slope: Floats) -> Floats:
    """The step that a search left undone: it ends where F falls by little."""
    at = Coordinates(solution.unknowns)
    prior = at.precision * (at.mean - at.inward(solution.values))
    return bounded_inverse(solution.information, solution.at_bound) @ (slope + prior)
