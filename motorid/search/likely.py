"""The default estimator on a batch model: output-error maximum likelihood within a box.

The engine is the six-parameter fit's own (``likelihood.py``): each channel's noise is found from
its residuals, and no channel needs a weight. It begins at a given point or at the middle of the
box; where what is left is no noise, it begins again at the best of a few points spread over it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

from motorid.estimate.results.estimate import Floats
from motorid.estimate.solver.dense_products import misfits
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Block, Solution, Unknown
from motorid.search.algorithms.population import SearchResult
from motorid.search.objective import Objective

ROUNDING = 1e-7  # of a channel's scale: the floor of a noise level
GROSS = 1e-3  # of a channel's scale, below which a misfit is the model's and not the search's
SCOUTS = 16  # points among which another start is chosen
STARTS = 4  # at most


class Readings:
    """An objective's residuals by channel, as the likelihood takes them; counts responses."""

    def __init__(self, objective: Objective) -> None:
        self.objective = objective
        self.unknowns: tuple[Unknown, ...] = ()
        self.blocks = tuple(
            Block(name, ROUNDING, float(np.count_nonzero(~np.isnan(y))), name)
            for record in objective.records
            for name, y in record.measured.items()
        )
        self.edges = np.cumsum([int(block.count) for block in self.blocks])[:-1]
        self.evaluations = 0
        self.history: list[tuple[int, float]] = []
        self.best = np.inf

    @property
    def simulated(self) -> int:
        """Responses so far."""
        return self.evaluations

    def residuals(self, shared: Floats, own: Floats) -> list[Floats]:
        """Measured less model, in units of the channels' scales."""
        self.evaluations += 1
        box = self.objective.box
        u = box.unit(np.clip(shared, box.low, box.high))
        with np.errstate(over="ignore", invalid="ignore"):
            left = -self.objective.residuals(u[None])[0]
        self.best = min(self.best, float(np.sqrt(np.mean(left**2))))
        self.history.append((self.evaluations, self.best))
        return list(np.split(left, self.edges))

    def foresee(self, points: Sequence[tuple[Floats, Floats]]) -> None:
        """Nothing is quicker at once."""

    def costs(self, u: Floats) -> Floats:
        """The objective at points (n, d) of the cube."""
        self.evaluations += len(u)
        return self.objective(u)


def likely(objective: Objective, *, seed: int, start: Floats | None = None) -> SearchResult:
    """The most likely point (d,) of the cube, from ``start`` or the middle."""
    readings, box = Readings(objective), objective.box
    u = np.full(box.d, 0.5) if start is None else np.clip(start, 0.0, 1.0)
    found = _from(readings, u)
    scouts = qmc.LatinHypercube(box.d, seed=seed)
    for _ in range(STARTS - 1):
        if not _misfits(readings, found):
            break
        points = scouts.random(SCOUTS)
        other = _from(readings, points[np.argmin(readings.costs(points))])
        if other.objective < found.objective:
            found = other
    best = box.unit(np.clip(found.values, box.low, box.high))
    cost = float(objective(best[None])[0])
    reason = "converged" if found.converged else "unsettled"
    history = np.array(readings.history, dtype=np.float64).reshape(-1, 2)
    return SearchResult("ml", best, cost, readings.evaluations, history, seed, reason)


def _from(readings: Readings, u: Floats) -> Solution:
    box = readings.objective.box
    unknowns = [
        Unknown(name, float(value), lower=float(low), upper=float(high), log=bool(low > 0))
        for name, value, low, high in zip(
            box.names, box.physical(u), box.low, box.high, strict=True
        )
    ]
    return maximise(unknowns, [readings])


def _misfits(readings: Readings, found: Solution) -> bool:
    if not found.converged:
        return True
    return any(misfits(left, GROSS) for left in readings.residuals(found.values, np.zeros(0)))
