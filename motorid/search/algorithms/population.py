"""What every search works on: a population with its costs, its luck and its budget.

A search is a generator function: it takes a :class:`Population`, and each ``yield`` ends one
generation. What it must remember from one generation to the next (velocities, counters) lives in
its local variables; what it has found lives in the population. So two searches can take turns on
one population, and that is all a hybrid is (``hybrid.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.errors import UsageError
from motorid.estimate.results.estimate import Floats
from motorid.search import bounds

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

WORST = 1e300  # the cost of a candidate that cannot be simulated: finite, so that means stay finite

Cost = Callable[[Floats], Floats]  # U (n, d) in [0, 1] -> cost (n,)
Start = Callable[[np.random.Generator, int, int], Floats]  # rng, n, d -> U (n, d)


class BudgetSpent(Exception):  # noqa: N818 (an ending, not an error)
    """The evaluations are used up; the population holds the answer."""


@dataclass(frozen=True)
class SearchResult:
    """What a search found.

    ``best`` (d,) is on the unit cube. ``history`` (m, 2) holds, after each batch, the evaluations
    so far and the lowest cost so far. ``reason`` is "budget", "target" or "converged".
    """

    method: str
    best: Floats
    cost: float
    evaluations: int
    history: Floats
    seed: int
    reason: str


class Population:
    """n candidates on the unit cube: ``u`` (n, d), ``cost`` (n,), and the best ever seen.

    Equal budgets are equal to the single evaluation: a batch that would pass the budget is cut,
    counted, and ends the search by BudgetSpent.
    """

    def __init__(self, f: Cost, d: int, budget: int, rng: np.random.Generator) -> None:
        self.f, self.d, self.budget, self.rng = f, d, budget, rng
        self.evaluations = 0
        self.u, self.cost = np.empty((0, d)), np.empty(0)
        self.best, self.best_cost = np.full(d, 0.5), np.inf
        self.history: list[tuple[int, float]] = []

    def begin(self, u: Floats) -> None:
        """Evaluate the first generation. Raises UsageError if the budget does not hold it."""
        if self.budget < len(u):
            raise UsageError(
                f"a budget of {self.budget} evaluations does not hold one population of {len(u)}: "
                "raise the budget or lower the population"
            )
        self.u, self.cost = u, self.evaluate(u)

    @property
    def n(self) -> int:
        """Size of the population."""
        return len(self.u)

    @property
    def progress(self) -> float:
        """t/T: the part of the budget behind the first generation that is used, 0 to 1."""
        return (self.evaluations - self.n) / max(self.budget - self.n, 1)

    def random(self, *shape: int) -> Floats:
        """Fresh U(0, 1), one for each component of the population unless a shape is given."""
        return self.rng.random(shape or self.u.shape)

    def evaluate(self, u: Floats) -> Floats:
        """Costs (n,) of candidates inside the cube; counts, remembers the best, keeps the budget.

        Raises BudgetSpent after the last evaluation that the budget allows.
        """
        affordable = u[: self.budget - self.evaluations]
        if not len(affordable):
            raise BudgetSpent
        cost = np.minimum(np.nan_to_num(self.f(affordable), nan=WORST, posinf=WORST), WORST)
        self.evaluations += len(affordable)
        leader = int(np.argmin(cost))
        if cost[leader] < self.best_cost:
            self.best, self.best_cost = affordable[leader].copy(), float(cost[leader])
        self.history.append((self.evaluations, self.best_cost))
        if len(affordable) < len(u):
            raise BudgetSpent
        return cost

    def keep_better(self, trial: Floats, rows: Indices | None = None) -> Mask:
        """Greedy selection: clip and evaluate trials for ``rows`` (default all), keep the better.

        Where a row has several trials the best of them wins. Returns which trials were no worse
        than what their row held before, shape (len(trial),).
        """
        rows = np.arange(self.n) if rows is None else rows
        trial = bounds.clip(trial)
        cost = self.evaluate(trial)
        better: Mask = cost <= self.cost[rows]
        order = np.argsort(-cost, kind="stable")  # the last assignment to a row is the cheapest
        order = order[better[order]]
        self.u[rows[order]], self.cost[rows[order]] = trial[order], cost[order]
        return better

    def replace(self, u: Floats) -> None:
        """Non-greedy selection: the new generation stands, better or worse."""
        u = bounds.clip(u)
        self.cost = self.evaluate(u)
        self.u = u


Search = Callable[[Population], Iterator[None]]


def others(rng: np.random.Generator, n: int, k: int) -> Indices:
    """k indices for each of n rows, distinct and not the row itself, shape (k, n)."""
    taken = np.arange(n)[None]  # sorted down each column
    chosen = []
    for _ in range(k):
        pick = rng.integers(n - len(taken), size=n)
        for used in taken:
            pick += pick >= used
        chosen.append(pick)
        taken = np.sort(np.vstack([taken, pick]), axis=0)
    return np.array(chosen)
