"""A record to explain and the bounds to search: the same problem, whatever the method."""

from __future__ import annotations

import functools
import time
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from motorid.errors import UsageError
from motorid.estimate.fit.steiglitz_mcbride import steiglitz_mcbride
from motorid.estimate.results.estimate import Diagnostic, Floats
from motorid.motor.batch import LINEAR, Model, Record
from motorid.search import registry, relations
from motorid.search.algorithms.population import SearchResult
from motorid.search.bounds import Box
from motorid.search.cache import Cache
from motorid.search.likely import likely
from motorid.search.nls import nls
from motorid.search.objective import Objective

ENDS = {"budget": "spent its budget", "converged": "settled", "target": "met its target"}
DIRECT = ("ml", "nls", "steiglitz-mcbride")  # methods that are no search of the cube


@dataclass(frozen=True)
class Problem:
    """Records of one motor. ``scale``: see Objective.

    ``acceleration``: dω/dt where it is known better than by differences of the speed.
    ``start``: SI values to begin from, for methods that begin at a point. ``given``: parameters
    of the model that are not searched. ``series_ohm`` lies outside the motor, in its circuit.
    """

    model: Model
    records: tuple[Record, ...]
    box: Box
    scale: Mapping[str, float]
    rms: bool = True
    acceleration: Floats | None = None
    start: Floats | None = None
    given: Mapping[str, float] = field(default_factory=dict)
    series_ohm: float = 0.0

    @property
    def step(self) -> Record:
        """The only record. Raises UsageError where there are several."""
        if len(self.records) != 1:
            raise UsageError(
                "the -m methods and Steiglitz-McBride take one step response, not "
                f"{len(self.records)} records: give one capture"
            )
        return self.records[0]

    def objective(self, kind: registry.Relations, rule: relations.Rule = "exact") -> Objective:
        """What a method with those relations searches. Raises UsageError for another model."""
        if kind == "none":
            fill = self._fill if self.given or self.series_ohm else None
            return Objective(self.model, self.records, self.box, self.scale, fill, self.rms)
        if self.model is not LINEAR:
            raise UsageError(
                f"the -m methods know the steady state of the linear model only, not of the "
                f"{self.model.name} model: use the method without -m"
            )
        facts = relations.step_facts(self.step, self.acceleration)
        names, expand = relations.EXPANSIONS[kind]
        box = relations.reduced_box(self.box, facts, names)
        expansion = functools.partial(expand, facts, rule)
        return Objective(self.model, self.records, box, self.scale, expansion, self.rms)

    def _fill(self, searched: Floats) -> Floats:
        """The model's parameters (n, p), the given ones and the series resistance put in."""
        columns = dict(zip(self.box.names, searched.T, strict=True))
        values = np.empty((len(searched), len(self.model.parameters)))
        for j, name in enumerate(self.model.parameters):
            values[:, j] = columns.get(name, self.given.get(name, np.nan))
            if name == "R":
                values[:, j] += self.series_ohm
        return values

    def named(self, values: Floats) -> dict[str, float]:
        """The model's parameters (p,) by name, those of the motor alone."""
        named = dict(zip(self.model.parameters, values.tolist(), strict=True))
        if "R" in named:
            named["R"] -= self.series_ohm
        return named


@dataclass(frozen=True)
class Solution:
    """A method's answer: SI ``values`` by name, and how it came about. ``hit_rate`` of memory."""

    method: str
    values: Mapping[str, float]
    cost: float
    evaluations: int
    seconds: float
    reason: str
    seed: int
    history: Floats
    hit_rate: float = 0.0


def remark(found: Solution) -> Diagnostic:
    """How a search ended, in a sentence."""
    ended = ENDS.get(found.reason, found.reason)
    repeated = f" ({100 * found.hit_rate:.2g} % answered from memory)" if found.hit_rate else ""
    return Diagnostic(
        "search",
        "info",
        f"the search {ended} after {found.evaluations} evaluations{repeated} at a cost of "
        f"{found.cost:.4g} (rms, in units of the peaks)",
    )


def names() -> tuple[str, ...]:
    """Every method that ``solve`` takes."""
    return (*DIRECT, *registry.METHODS)


def solve(
    problem: Problem,
    method: str,
    *,
    budget: int,
    seed: int,
    n: int | None = None,
    rule: relations.Rule = "exact",
    memory: bool = False,
    target: float = -np.inf,
) -> Solution:
    """Solve by name. ``memory``: with memory assistance. Raises UsageError for an unknown name."""
    begin = time.perf_counter()
    if method == "steiglitz-mcbride":
        return _steiglitz_mcbride(problem, seed, begin)
    chosen = None if method in DIRECT else registry.get(method)
    objective = problem.objective(chosen.relations if chosen else "none", rule)
    hit_rate = 0.0
    if method == "ml":
        found = likely(objective, seed=seed, start=_start(problem))
    elif chosen is None:
        found = nls(objective, budget=budget, seed=seed, start=_start(problem))
    else:
        cost = Cache(objective) if memory else objective
        start = _start(problem) if chosen.begins_at_a_point else None
        first = None if start is None else functools.partial(_at, start)
        found = registry.minimise(
            chosen, cost, objective.box.d, budget=budget, seed=seed, n=n, target=target, first=first
        )
        hit_rate = cost.hit_rate if isinstance(cost, Cache) else 0.0
    return _solution(problem, objective, found, begin, hit_rate)


def _start(problem: Problem) -> Floats | None:
    return None if problem.start is None else problem.box.unit(problem.start)


def _at(start: Floats, rng: np.random.Generator, n: int, d: int) -> Floats:
    return np.vstack([start, rng.random((n - 1, d))])


def _solution(
    problem: Problem, objective: Objective, found: SearchResult, begin: float, hit_rate: float
) -> Solution:
    values = objective.values(found.best)[0]
    return Solution(
        found.method,
        problem.named(values),
        found.cost,
        found.evaluations,
        time.perf_counter() - begin,
        found.reason,
        found.seed,
        found.history,
        hit_rate,
    )


def _steiglitz_mcbride(problem: Problem, seed: int, begin: float) -> Solution:
    if problem.model is not LINEAR:
        raise UsageError("Steiglitz-McBride fits the linear model only")
    found = steiglitz_mcbride(problem.step)
    values = problem.named(np.array(list(found.values.values())))
    u = problem.box.unit(np.array([list(values.values())]))
    cost = float(problem.objective("none")(u)[0])
    return Solution(
        "steiglitz-mcbride",
        values,
        cost,
        found.passes,
        time.perf_counter() - begin,
        "converged" if found.settled else "budget",
        seed,
        np.array([[found.passes, cost]], dtype=np.float64),
    )
