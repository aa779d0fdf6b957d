"""Jaya (Rao 2016): towards the best, away from the worst. It has no constants."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.search.algorithms.population import Population


def jaya(population: Population) -> Iterator[None]:
    """x' = x + r1 (x_best - |x|) - r2 (x_worst - |x|), kept where it is no worse."""
    while True:
        x, size = population.u, np.abs(population.u)
        best, worst = x[np.argmin(population.cost)], x[np.argmax(population.cost)]
        to_best = population.random() * (best - size)
        from_worst = population.random() * (worst - size)
        population.keep_better(x + to_best - from_worst)
        yield
