"""Cuckoo search by Lévy flights, as Yang and Deb's published code does it (2009, 2010)."""

from __future__ import annotations

from collections.abc import Iterator
from math import gamma, pi, sin

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search.algorithms.population import Population

PA = 0.25  # fraction of eggs that are found
BETA = 1.5  # exponent of the flights
STEP = 0.01  # of the flight, in units of the distance to the best nest
SIGMA = (
    gamma(1 + BETA) * sin(pi * BETA / 2) / (gamma((1 + BETA) / 2) * BETA * 2 ** ((BETA - 1) / 2))
) ** (1 / BETA)  # .6966, Mantegna 1994


def cuckoo(population: Population, moved: float = 1.0 - PA) -> Iterator[None]:
    """Lévy flights round the best nest, then found eggs are laid between two others.

    ``moved`` is the part of all components that the second phase moves. The authors' code moves
    those with r > pa, 75 %; their text says the fraction pa, 25 %.
    """
    rng, n = population.rng, population.n
    while True:
        x = population.u
        leader = x[np.argmin(population.cost)]
        flight = STEP * levy(rng, x.shape) * (x - leader) * rng.standard_normal(x.shape)
        population.keep_better(x + flight)

        x = population.u
        walk = rng.random() * (x[rng.permutation(n)] - x[rng.permutation(n)])
        population.keep_better(x + walk * (population.random() < moved))
        yield


def cuckoo_25(population: Population) -> Iterator[None]:
    """The search of the authors' text: a quarter of the components moves."""
    return cuckoo(population, moved=PA)


def levy(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Mantegna's heavy-tailed steps s = N(0, sigma²)/|N(0, 1)|^(1/beta)."""
    return np.asarray(
        SIGMA * rng.standard_normal(shape) / np.abs(rng.standard_normal(shape)) ** (1 / BETA)
    )
