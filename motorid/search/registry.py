"""Every search by its name, with its usual population and where it comes from."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorid.errors import UsageError
from motorid.search import bounds
from motorid.search.algorithms import abc, aco, chaos, cuckoo, de, ga, gwo, hybrid, jaya, pso, tlbo
from motorid.search.algorithms import pattern_search as patterns
from motorid.search.algorithms.population import (
    BudgetSpent,
    Cost,
    Population,
    Search,
    SearchResult,
    Start,
)

Relations = Literal["none", "steady", "steady+peak", "steady+near-peak"]
Size = Callable[[int], int]  # number of parameters -> population


@dataclass(frozen=True)
class Method:
    """A search as the review names it.

    ``relations``: what the data's steady state fixes before the search begins (``relations.py``):
    nothing; R and B from K; J as well, at maximum current; or J within a tenth of that.
    ``begins_at_a_point``: a guess of the answer is its first candidate.
    """

    name: str
    title: str
    search: Search
    source: str
    population: Size = lambda d: 30
    start: Start = bounds.uniform
    relations: Relations = "none"
    begins_at_a_point: bool = False


def _all() -> tuple[Method, ...]:
    peak: Relations = "steady+peak"
    near: Relations = "steady+near-peak"
    rand, constricted = de.rand_1_exp, pso.constricted

    def de_size(d: int) -> int:
        return de.NP_PER_DIMENSION * d

    def nests(d: int) -> int:
        return 25

    return (
        Method(
            "pattern-search",
            "Pattern search",
            patterns.pattern_search,
            "[11]",
            lambda d: 1,
            begins_at_a_point=True,
        ),
        Method("ga", "Genetic algorithm", ga.ga, "[18]"),
        Method("de-rand-1-exp", "DE/rand/1/exp", rand, "[18]", de_size),
        Method("de-best-1-bin", "DE/best/1/bin", de.best_1_bin, "[18]", de_size),
        Method("tlbo", "Teaching-learning", tlbo.tlbo, "[18]"),
        Method("abc", "Artificial bee colony", abc.abc, "[18]"),
        Method("pso", "Standard PSO", pso.standard, "[26]"),
        Method("pso-inertia", "PSO, inertia .7298", pso.inertia, "Clerc and Kennedy 2002"),
        Method("pso-ldw", "PSO, inertia .9 to .4", pso.decreasing, "[27]"),
        Method("pso-ciw", "Constricted PSO, decreasing inertia", constricted, "[26]"),
        Method("pso-aiwf", "PSO, adaptive inertia", pso.adaptive, "[26]"),
        Method(
            "pso-ci", "Chaos-initialised PSO", pso.decreasing, "[26, 27]", start=chaos.tent_start
        ),
        Method("cuckoo", "Cuckoo search, 75 % moved", cuckoo.cuckoo, "[39]", nests),
        Method("cuckoo-25", "Cuckoo search, 25 % moved", cuckoo.cuckoo_25, "[39]", nests),
        Method("cuckoo-m", "Modified cuckoo", cuckoo.cuckoo, "[39]", nests, relations="steady"),
        Method("cuckoo-m-peak", "Cuckoo, J by (30)", cuckoo.cuckoo, "[40]", nests, relations=peak),
        Method(
            "cuckoo-m-near", "Cuckoo, J near (30)", cuckoo.cuckoo, "[40]", nests, relations=near
        ),
        Method("gwo", "Grey wolf", gwo.gwo, "[40]"),
        Method("gwo-m", "Modified grey wolf", gwo.gwo, "[40]", relations=peak),
        Method("jaya", "Jaya", jaya.jaya, "[40]"),
        Method("jaya-m", "Modified Jaya", jaya.jaya, "[40]", relations=peak),
        Method("aco", "Ant colony, continuous", aco.aco, "Socha and Dorigo 2008"),
        Method(
            "pso-ci-ciw",
            "Chaos-initialised constricted PSO",
            constricted,
            "proposed in 3.3",
            start=chaos.tent_start,
        ),
        Method(
            "cuckoo-ga", "Cuckoo with GA", hybrid.hybrid(cuckoo.cuckoo, ga.ga), "proposed in 3.4"
        ),
        *(
            Method(
                f"de-{name}", f"DE with {title}", hybrid.hybrid(rand, search), "Table 11", de_size
            )
            for name, title, search in (
                ("pso", "PSO", constricted),
                ("cuckoo", "CS", cuckoo.cuckoo),
                ("abc", "ABC", abc.abc),
                ("ga", "GA", ga.ga),
                ("aco", "ACO", aco.aco),
            )
        ),
    )


METHODS = {method.name: method for method in _all()}


def get(name: str) -> Method:
    """The method of that name. Raises UsageError that names the nearest."""
    if name not in METHODS:
        near = difflib.get_close_matches(name, METHODS, 1)
        hint = f"did you mean {near[0]}?" if near else f"choose from {', '.join(METHODS)}"
        raise UsageError(f"no search method {name}: {hint}")
    return METHODS[name]


def minimise(
    method: Method | str,
    f: Cost,
    d: int,
    *,
    budget: int,
    seed: int,
    n: int | None = None,
    target: float = -np.inf,
    first: Start | None = None,
) -> SearchResult:
    """Minimise f over the unit cube of d dimensions with at most ``budget`` evaluations.

    ``n``: population (default: the method's own). ``target``: stop at this cost.
    ``first``: another first generation. Equal arguments give equal results.
    Raises UsageError for an unknown method or a budget below one population.
    """
    method = get(method) if isinstance(method, str) else method
    rng = np.random.default_rng(seed)
    population = Population(f, d, budget, rng)
    reason = "converged"
    try:
        population.begin((first or method.start)(rng, n or method.population(d), d))
        for _ in method.search(population):
            if population.best_cost <= target:
                reason = "target"
                break
    except BudgetSpent:
        reason = "budget"
    return SearchResult(
        method.name,
        population.best,
        population.best_cost,
        population.evaluations,
        np.array(population.history, dtype=np.float64),
        seed,
        reason,
    )
