"""Teaching-learning-based optimisation (Rao, Savsani and Vakharia 2011). It has no constants."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.search.algorithms.population import Population, others


def tlbo(population: Population) -> Iterator[None]:
    """Teacher phase, then learner phase: two evaluations of each individual a generation."""
    while True:
        x = population.u
        teacher = x[np.argmin(population.cost)]
        factor = population.rng.integers(1, 3, size=(population.n, 1))  # TF is 1 or 2
        population.keep_better(x + population.random() * (teacher - factor * x.mean(axis=0)))

        x, cost = population.u, population.cost
        (j,) = others(population.rng, population.n, 1)
        away_or_to = np.where(cost < cost[j], 1.0, -1.0)[:, None]
        population.keep_better(x + population.random() * away_or_to * (x - x[j]))
        yield
