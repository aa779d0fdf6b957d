"""Our searches against scipy's, pymoo's and pygmo's: same constants, same problem, many seeds.

Equal convergence: a two-sided rank test on the final costs does not tell them apart (p > .01),
and the medians lie within a quarter of the distance that the search covers in powers of ten.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, stats

from motorid.search import minimise
from motorid.search.algorithms import de, ga, gwo, pso
from motorid.search.algorithms.abc import abc
from motorid.search.registry import Method

pygmo = pytest.importorskip("pygmo", reason="pygmo is not installed: no oracle for this search")
pytestmark = pytest.mark.slow

D = 5
CENTRE = np.array([0.37, 0.55, 0.42, 0.61, 0.48])
WEIGHTS = 10.0 ** np.linspace(0.0, 2.0, D)
SEEDS = range(25)


def ellipsoid(u: np.ndarray) -> np.ndarray:
    """Costs (n,) with turned axes: no component can be found alone."""
    x = u - CENTRE
    x = x + 0.3 * np.roll(x, 1, axis=1)
    return (WEIGHTS * x**2).sum(axis=1)


class Problem:
    """The ellipsoid for pygmo."""

    def fitness(self, x: np.ndarray) -> list[float]:
        return [float(ellipsoid(np.atleast_2d(x))[0])]

    def get_bounds(self) -> tuple[list[float], list[float]]:
        return [0.0] * D, [1.0] * D


def ours(search, n: int, generations: int, each: int = 1) -> np.ndarray:
    method = Method("under test", "", search, "", lambda d: n)
    budget = n * (1 + each * generations)
    return np.array(
        [minimise(method, ellipsoid, D, budget=budget, seed=seed).cost for seed in SEEDS]
    )


def pygmos(algorithm, n: int) -> np.ndarray:
    costs = []
    for seed in SEEDS:
        user = algorithm(seed + 1)
        population = pygmo.population(pygmo.problem(Problem()), n, seed=seed + 1)
        costs.append(pygmo.algorithm(user).evolve(population).champion_f[0])
    return np.array(costs)


def assert_alike(mine: np.ndarray, theirs: np.ndarray) -> None:
    start = np.log10(np.median(ellipsoid(np.random.default_rng(0).random((1000, D)))))
    a, b = np.log10(np.maximum(mine, 1e-300)), np.log10(np.maximum(theirs, 1e-300))
    covered = start - np.median(b)
    assert covered > 1.0, "the oracle did not search: the comparison says nothing"
    assert abs(np.median(a) - np.median(b)) < 0.25 * covered
    assert stats.mannwhitneyu(a, b).pvalue > 0.01


def scipys(strategy: str, generations: int) -> np.ndarray:
    return np.array(
        [
            optimize.differential_evolution(
                lambda x: ellipsoid(x.T),
                [(0.0, 1.0)] * D,
                strategy=strategy,
                mutation=de.F,
                recombination=de.CR,
                popsize=de.NP_PER_DIMENSION,
                maxiter=generations,
                init="random",
                updating="deferred",
                vectorized=True,
                polish=False,
                tol=0.0,
                rng=np.random.default_rng(seed),
            ).fun
            for seed in SEEDS
        ]
    )


@pytest.mark.parametrize(
    ("search", "strategy"),
    [
        pytest.param(de.rand_1_exp, "rand1exp", marks=pytest.mark.study),
        (de.best_1_bin, "best1bin"),
    ],
)
def test_differential_evolution_converges_as_scipys(search, strategy):
    assert_alike(ours(search, 50, 60), scipys(strategy, 60))


@pytest.mark.parametrize(
    ("search", "variant"),
    [(de.rand_1_exp, 2), pytest.param(de.best_1_bin, 6, marks=pytest.mark.study)],
)
def test_differential_evolution_converges_as_pygmos(search, variant):
    theirs = pygmos(
        lambda seed: pygmo.de(60, de.F, de.CR, variant, ftol=0.0, xtol=0.0, seed=seed), 50
    )
    assert_alike(ours(search, 50, 60), theirs)


def test_grey_wolf_converges_as_pygmos():
    theirs = pygmos(lambda seed: pygmo.gwo(60, seed=seed), 30)
    assert_alike(ours(gwo.gwo, 30, 60), theirs)


def test_bee_colony_converges_as_pygmos():
    theirs = pygmos(lambda seed: pygmo.bee_colony(60, limit=30 * D, seed=seed), 30)
    assert_alike(ours(abc, 30, 60, each=2), theirs)


def test_swarm_converges_as_pygmos():
    theirs = pygmos(
        lambda seed: pygmo.pso_gen(
            60, pso.W_CLERC, pso.C_CLERC, pso.C_CLERC, pso.MAX_VELOCITY, 1, 1, 4, seed=seed
        ),
        30,
    )
    assert_alike(ours(pso.inertia, 30, 60), theirs)


def pymoos(algorithm, generations: int) -> np.ndarray:
    core = pytest.importorskip("pymoo.core.problem", reason="pymoo is not installed")
    from pymoo.optimize import minimize

    class Ellipsoid(core.Problem):
        def __init__(self) -> None:
            super().__init__(n_var=D, n_obj=1, xl=0.0, xu=1.0)

        def _evaluate(self, x, out, *args, **kwargs) -> None:
            out["F"] = ellipsoid(x)[:, None]

    return np.array(
        [
            minimize(Ellipsoid(), algorithm(), ("n_gen", generations + 1), seed=seed).F[0]
            for seed in SEEDS
        ]
    )


@pytest.mark.study
def test_swarm_converges_as_pymoos():
    PSO = pytest.importorskip("pymoo.algorithms.soo.nonconvex.pso", reason="no pymoo").PSO
    from pymoo.operators.sampling.rnd import FloatRandomSampling

    theirs = pymoos(
        lambda: PSO(
            pop_size=30,
            sampling=FloatRandomSampling(),
            w=pso.W_CLERC,
            c1=pso.C_CLERC,
            c2=pso.C_CLERC,
            adaptive=False,
            initial_velocity="zero",
            max_velocity_rate=pso.MAX_VELOCITY,
            pertube_best=False,
        ),
        60,
    )
    assert_alike(ours(pso.inertia, 30, 60), theirs)


def pymoo_problem():
    core = pytest.importorskip("pymoo.core.problem", reason="pymoo is not installed")
    return core.Problem(n_var=1, n_obj=1, xl=0.0, xu=1.0)


def test_crossover_spreads_children_as_pymoos():
    problem = pymoo_problem()
    from pymoo.operators.crossover.sbx import cross_sbx

    n = 20_000
    parents = np.stack([np.full((n, 1), 0.45), np.full((n, 1), 0.55)])
    low, high = np.zeros(1), np.ones(1)
    rng = np.random.default_rng(1)
    eta, never = np.full((n, 1), ga.ETA_C), np.zeros((n, 1))
    theirs = cross_sbx(parents, low, high, eta, 1.0, never, random_state=rng)[0]
    mine = ga.crossover(parents[0], parents[1], np.random.default_rng(2))
    mine = mine[(mine != 0.45).ravel()]  # a tenth of the pairs is not crossed
    assert problem.n_var == 1
    assert stats.ks_2samp(np.abs(mine.ravel() - 0.5), np.abs(theirs.ravel() - 0.5)).pvalue > 0.01


def test_mutation_spreads_as_pymoos():
    pymoo_problem()
    from pymoo.operators.mutation.pm import mut_pm

    n = 20_000
    start = np.full((n, 1), 0.5)
    eta, probability = np.full(n, ga.ETA_M), np.ones(n)
    theirs = mut_pm(
        start, np.zeros(1), np.ones(1), eta, probability, False,
        random_state=np.random.default_rng(1),
    )  # fmt: skip
    mine = ga.mutate(start, np.random.default_rng(2), 1.0)
    assert abs(np.std(mine) / np.std(theirs) - 1.0) < 0.05
    assert abs(np.quantile(mine, 0.9) - np.quantile(theirs, 0.9)) < 0.005
