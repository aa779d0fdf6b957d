"""Real-coded genetic algorithm: Deb and Agrawal's crossover (1995) and polynomial mutation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search import bounds
from motorid.search.algorithms.population import Indices, Population

TOURNAMENT = 2
CROSSOVER = 0.9  # probability of a pair
ETA_C = 15.0  # distribution index of the crossover
ETA_M = 20.0  # distribution index of the mutation; its probability is 1/d a component


def ga(population: Population) -> Iterator[None]:
    """Tournament, simulated binary crossover, polynomial mutation; the best one survives."""
    rng, d = population.rng, population.d
    while True:
        elite = population.u[np.argmin(population.cost)].copy()
        first, second = (population.u[tournament(population)] for _ in range(2))
        children = crossover(first, second, rng)
        children = mutate(bounds.clip(children), rng, 1.0 / d)
        children[0] = elite
        population.replace(children)
        yield


def tournament(population: Population) -> Indices:
    """Indices (n,) of the better of ``TOURNAMENT`` random ones."""
    rivals = population.rng.integers(population.n, size=(TOURNAMENT, population.n))
    winner = np.argmin(population.cost[rivals], axis=0)
    return np.asarray(rivals[winner, np.arange(population.n)])


def crossover(first: Floats, second: Floats, rng: np.random.Generator) -> Floats:
    """One child a pair, (n, d): c = .5 [(1 ± beta) p1 + (1 ∓ beta) p2], the sign by chance."""
    r = rng.random(first.shape)
    beta = np.where(r <= 0.5, 2.0 * r, 1.0 / (2.0 * (1.0 - r))) ** (1.0 / (ETA_C + 1.0))
    beta = beta * rng.choice([-1.0, 1.0], size=(len(first), 1))
    crossed = 0.5 * ((1.0 + beta) * first + (1.0 - beta) * second)
    return np.where(rng.random((len(first), 1)) < CROSSOVER, crossed, first)


def mutate(u: Floats, rng: np.random.Generator, probability: float) -> Floats:
    """Each component moves by delta with the given probability, (n, d)."""
    r = rng.random(u.shape)
    power = 1.0 / (ETA_M + 1.0)
    delta = np.where(r < 0.5, (2.0 * r) ** power - 1.0, 1.0 - (2.0 * (1.0 - r)) ** power)
    return np.where(rng.random(u.shape) < probability, u + delta, u)
