"""Artificial bee colony (Karaboga 2005; Karaboga and Basturk 2007)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search.algorithms.population import Indices, Population

# Onlookers choose by .9 fit/max + .1, Karaboga's own form: it still prefers when fit is nearly
# the same everywhere, as 1/(1 + cost) is once costs are small.
PREFERENCE, FLOOR = 0.9, 0.1


def abc(population: Population) -> Iterator[None]:
    """Employed bees, onlookers, and one scout for a source that failed more than SN·d times."""
    n, rng = population.n, population.rng
    limit = n * population.d
    failures = np.zeros(n, dtype=np.int64)
    while True:
        _forage(population, np.arange(n), failures)
        fit = 1.0 / (1.0 + population.cost)
        weight = PREFERENCE * fit / fit.max() + FLOOR
        _forage(population, rng.choice(n, size=n, p=weight / weight.sum()), failures)

        tired = int(np.argmax(failures))
        if failures[tired] > limit:
            fresh = population.random(1, population.d)
            population.u[tired], population.cost[tired] = fresh[0], population.evaluate(fresh)[0]
            failures[tired] = 0
        yield


def _forage(population: Population, sources: Indices, failures: Indices) -> None:
    better = population.keep_better(neighbour(population, sources), sources)
    np.add.at(failures, sources[~better], 1)
    failures[sources[better]] = 0


def neighbour(population: Population, sources: Indices) -> Floats:
    """v_j = x_j + phi (x_j - x_kj) in one random component j, phi in U(-1, 1), (len, d)."""
    rng, m = population.rng, len(sources)
    j = rng.integers(population.d, size=m)
    k = (sources + rng.integers(1, population.n, size=m)) % population.n  # not the source itself
    v: Floats = population.u[sources]
    row = np.arange(m)
    v[row, j] += rng.uniform(-1.0, 1.0, m) * (v[row, j] - population.u[k, j])
    return v
