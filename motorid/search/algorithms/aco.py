"""Ant colony optimisation for continuous domains, ACO_R (Socha and Dorigo 2008)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search import bounds
from motorid.search.algorithms.population import Indices, Population

Q = 0.1  # locality: width of the preference for good solutions, in archive lengths (our choice)
XI = 0.85  # pheromone evaporation: scale of the spread (the authors' value, from memory)


def aco(population: Population) -> Iterator[None]:
    """Each ant samples round a solution of the archive; the archive keeps the best n of all."""
    rng, n = population.rng, population.n
    weight = np.exp(-(np.arange(n) ** 2) / (2.0 * (Q * n) ** 2))
    while True:
        order = np.argsort(population.cost, kind="stable")
        archive, cost = population.u[order], population.cost[order]
        guide = rng.choice(n, size=n, p=weight / weight.sum())
        ants = bounds.clip(
            archive[guide] + spread(archive, guide) * rng.standard_normal(archive.shape)
        )
        everyone = np.vstack([archive, ants])
        everyone_cost = np.concatenate([cost, population.evaluate(ants)])
        best = np.argsort(everyone_cost, kind="stable")[:n]
        population.u, population.cost = everyone[best], everyone_cost[best]
        yield


def spread(archive: Floats, guide: Indices) -> Floats:
    """sigma = xi · mean distance of the guide to the other solutions, by component, (n, d)."""
    distance = np.abs(archive[:, None, :] - archive[None, :, :]).sum(axis=1)
    return np.asarray(XI * distance[guide] / max(len(archive) - 1, 1))
