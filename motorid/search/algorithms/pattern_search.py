"""Generalised pattern search with the 2d coordinate directions (Torczon 1997; Audet, Dennis 2003).

The rule of [11]'s tool: complete poll, mesh twice as wide after a success, half as wide after a
failure.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.search import bounds
from motorid.search.algorithms.population import Population

MESH_FIRST = 0.25  # of the cube's side
MESH_LAST = 1e-9  # converged below this


def pattern_search(population: Population) -> Iterator[None]:
    """Poll x ± mesh e_j all at once, go to the best if it is better; ends when the mesh is fine."""
    x, cost = population.best.copy(), population.best_cost
    directions = np.vstack([np.eye(population.d), -np.eye(population.d)])
    mesh = MESH_FIRST
    while mesh > MESH_LAST:
        poll = bounds.clip(x + mesh * directions)
        found = population.evaluate(poll)
        leader = int(np.argmin(found))
        if found[leader] < cost:
            x, cost = poll[leader], float(found[leader])
            population.u[0], population.cost[0] = x, cost
            mesh = min(2.0 * mesh, 1.0)
        else:
            mesh /= 2.0
        yield
