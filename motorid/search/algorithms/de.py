"""Differential evolution (Storn and Price 1997), the two strategies of Jesenik et al. 2020."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.search import bounds
from motorid.search.algorithms.population import Mask, Population, others

F = 0.6  # scale of the difference; F, CR and NP proposed for the review, which prints none
CR = 0.8  # crossover rate
NP_PER_DIMENSION = 10  # population a parameter


def rand_1_exp(population: Population, f: float = F, cr: float = CR) -> Iterator[None]:
    """v = x_r1 + F (x_r2 - x_r3); one run of components, cyclic, copied from v."""
    while True:
        x = population.u
        r1, r2, r3 = others(population.rng, population.n, 3)
        mutant = x[r1] + f * (x[r2] - x[r3])
        _select(population, mutant, exponential(population, cr))
        yield


def best_1_bin(population: Population, f: float = F, cr: float = CR) -> Iterator[None]:
    """v = x_best + F (x_r1 - x_r2); each component from v with probability CR, one for sure."""
    while True:
        x = population.u
        leader = x[np.argmin(population.cost)]
        r1, r2 = others(population.rng, population.n, 2)
        mutant = leader + f * (x[r1] - x[r2])
        _select(population, mutant, binomial(population, cr))
        yield


def exponential(population: Population, cr: float) -> Mask:
    """Which components come from the mutant, (n, d): from j0 on while r < CR."""
    n, d = population.u.shape
    goes_on = np.cumprod(population.random(n, d - 1) < cr, axis=1).astype(bool)
    in_run = np.hstack([np.ones((n, 1), bool), goes_on])
    start = population.rng.integers(d, size=(n, 1))
    return np.take_along_axis(in_run, (np.arange(d) - start) % d, axis=1)


def binomial(population: Population, cr: float) -> Mask:
    """Which components come from the mutant, (n, d): each where r < CR, and j_rand."""
    n, d = population.u.shape
    chosen = population.random() < cr
    chosen[np.arange(n), population.rng.integers(d, size=n)] = True
    return chosen


def _select(population: Population, mutant: Floats, from_mutant: Mask) -> None:
    trial = np.where(from_mutant, mutant, population.u)
    population.keep_better(bounds.redraw(trial, population.rng))
