"""Grey wolf optimiser (Mirjalili, Mirjalili and Lewis 2014)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.search.algorithms.population import Population

LEADERS = 3  # alpha, beta, delta
A_FIRST = 2.0  # a falls from here to 0 over the budget


def gwo(population: Population) -> Iterator[None]:
    """Every wolf goes to the mean of three points near the best three ever seen; no greed."""
    leaders, leader_cost = population.u[:0], population.cost[:0]
    while True:
        pack = np.vstack([leaders, population.u])
        cost = np.concatenate([leader_cost, population.cost])
        order = np.argsort(cost, kind="stable")[:LEADERS]
        leaders, leader_cost = pack[order], cost[order]

        a = A_FIRST * (1.0 - population.progress)
        x = population.u[:, None, :]  # (n, 1, d) against (3, d)
        A = a * (2.0 * population.random(population.n, len(leaders), population.d) - 1.0)
        C = 2.0 * population.random(population.n, len(leaders), population.d)
        population.replace((leaders - A * np.abs(C * leaders - x)).mean(axis=1))
        yield
