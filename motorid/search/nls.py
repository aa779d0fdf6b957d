"""Nonlinear least squares [11]: trust-region reflective steps on all scaled residuals at once.

The Jacobian's columns are one batch of candidates. Starts again from a random point of the cube
until the budget is spent or two starts agree.
"""

from __future__ import annotations

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search.algorithms.population import WORST, BudgetSpent, SearchResult
from motorid.search.objective import Objective

STEP = 1e-6  # of the cube's side, for central differences
AGREE = 1e-6  # relative difference of two costs that count as one minimum,
ZERO = 1e-9  # and a cost that counts as none, in scaled units
TOLERANCE = 1e-12
FAR = 1e12  # residual of a candidate that leaves the doubles


class _Counted:
    """Residuals within a budget; remembers the best cost."""

    def __init__(self, objective: Objective, budget: int) -> None:
        self.objective, self.budget = objective, budget
        self.evaluations = 0
        self.best, self.cost = np.full(objective.box.d, 0.5), np.inf
        self.history: list[tuple[int, float]] = []

    def __call__(self, u: Floats) -> Floats:
        residuals: Floats = self._run(u[None])[0]
        cost = float(np.sqrt(np.mean(residuals**2)))
        if cost < self.cost:
            self.best, self.cost = u.copy(), cost
        self.history.append((self.evaluations, self.cost))
        return residuals

    def jacobian(self, u: Floats) -> Floats:
        """Central differences, (readings, d), from one batch of 2d candidates."""
        steps = STEP * np.eye(len(u))
        ahead, behind = np.split(self._run(np.vstack([u + steps, u - steps])), 2)
        return np.asarray((ahead - behind).T / (2 * STEP))

    def _run(self, u: Floats) -> Floats:
        if self.evaluations + len(u) > self.budget:
            raise BudgetSpent
        self.evaluations += len(u)
        with np.errstate(over="ignore", invalid="ignore"):
            residuals = self.objective.residuals(u)
        return np.clip(np.nan_to_num(residuals, nan=FAR), -FAR, FAR)


def nls(
    objective: Objective, *, budget: int, seed: int, start: Floats | None = None
) -> SearchResult:
    """Minimise the objective's residuals from ``start`` (d,) (default: the cube's centre)."""
    from scipy.optimize import least_squares

    rng = np.random.default_rng(seed)
    counted = _Counted(objective, budget)
    u = np.full(objective.box.d, 0.5) if start is None else start
    minima: list[float] = []
    reason = "converged"
    try:
        while True:
            fit = least_squares(
                counted,
                np.clip(u, 1e-6, 1.0 - 1e-6),
                counted.jacobian,
                bounds=(0.0, 1.0),
                ftol=TOLERANCE,
                xtol=TOLERANCE,
                gtol=TOLERANCE,
            )
            minima.append(float(np.sqrt(np.mean(fit.fun**2))))
            lowest = min(minima)
            if sum(m <= lowest * (1.0 + AGREE) + ZERO for m in minima) > 1:
                break
            u = rng.random(objective.box.d)
    except BudgetSpent:
        reason = "budget"
    history = np.array(counted.history, dtype=np.float64).reshape(-1, 2)
    cost = float(min(counted.cost, WORST))
    return SearchResult("nls", counted.best, cost, counted.evaluations, history, seed, reason)
