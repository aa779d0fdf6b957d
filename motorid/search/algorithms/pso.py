"""Particle swarms: standard, and the three that Table 5 of the review compares.

A swarm's population holds the personal bests p; the particles themselves are the swarm's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search import bounds
from motorid.search.algorithms.population import Population

MAX_VELOCITY = 0.2  # of the cube's side, a generation
C = 2.0  # c1 = c2, Kennedy and Eberhart 1995
W_FIRST, W_LAST = 0.9, 0.4  # linearly decreasing inertia, Shi and Eberhart 1998
W_CLERC, C_CLERC = 0.7298, 1.49618  # the constricted swarm written as an inertia
PHI = 4.1  # phi1 + phi2, Clerc and Kennedy 2002
CHI = 2.0 / abs(2.0 - PHI - (PHI**2 - 4.0 * PHI) ** 0.5)  # .7298
W_MIN, W_MAX = 0.2, 1.2  # adaptive inertia, Liu et al. 2005 (from memory)

Inertia = Callable[[float, Floats], float | Floats]  # progress, costs (n,) -> w or w (n, 1)


def standard(population: Population) -> Iterator[None]:
    """The original swarm: w = 1, c1 = c2 = 2, held only by the velocity limit."""
    return swarm(population, lambda t, cost: 1.0)


def inertia(population: Population) -> Iterator[None]:
    """Constant inertia .7298 and c = 1.49618."""
    return swarm(population, lambda t, cost: W_CLERC, c=C_CLERC)


def decreasing(population: Population) -> Iterator[None]:
    """Inertia from .9 to .4 over the budget, c1 = c2 = 2."""
    return swarm(population, lambda t, cost: W_FIRST - (W_FIRST - W_LAST) * t)


def constricted(population: Population) -> Iterator[None]:
    """CIW: v = chi [w v + phi1 r1 (p - x) + phi2 r2 (g - x)], w from .9 to .4."""
    return swarm(population, lambda t, cost: W_FIRST - (W_FIRST - W_LAST) * t, PHI / 2, CHI)


def adaptive(population: Population) -> Iterator[None]:
    """AIWF: particles better than average get the smaller inertia."""
    return swarm(population, adaptive_inertia)


def adaptive_inertia(progress: float, cost: Floats) -> Floats:
    """w (n, 1): wmin at the best cost, linear up to wmax at the average, wmax above it."""
    best, average = cost.min(), cost.mean()
    spread = max(average - best, np.finfo(float).tiny)
    w = W_MIN + (W_MAX - W_MIN) * (cost - best) / spread
    return np.where(cost <= average, w, W_MAX)[:, None]


def swarm(population: Population, w: Inertia, c: float = C, chi: float = 1.0) -> Iterator[None]:
    """v = chi [w v + c r1 (p - x) + c r2 (g - x)], x = x + v, |v| at most ``MAX_VELOCITY``."""
    x, cost = population.u.copy(), population.cost.copy()
    v = np.zeros_like(x)
    while True:
        pull = population.random() * (population.u - x)
        lead = population.random() * (population.best - x)
        v = chi * (w(population.progress, cost) * v + c * (pull + lead))
        v = np.clip(v, -MAX_VELOCITY, MAX_VELOCITY)
        x, v = bounds.bounce(x + v, v)
        cost = population.evaluate(x)
        better = cost <= population.cost
        population.u[better], population.cost[better] = x[better], cost[better]
        yield
