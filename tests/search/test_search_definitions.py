"""Searches that no oracle library has, against plain loops of their definitions; and the pieces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from motorid.errors import UsageError
from motorid.search import METHODS, bounds, minimise
from motorid.search.algorithms import chaos, cuckoo, jaya, pso, tlbo
from motorid.search.algorithms.de import binomial, exponential
from motorid.search.algorithms.population import Population, others
from motorid.search.cache import Cache
from motorid.search.registry import Method, get

D = 4
CENTRE = np.array([0.4, 0.6, 0.45, 0.55])
N, GENERATIONS, SEEDS = 15, 40, range(20)


def bowl(u: np.ndarray) -> np.ndarray:
    x = u - CENTRE
    return ((1.0 + 9.0 * np.arange(D)) * (x + 0.3 * np.roll(x, 1, axis=1)) ** 2).sum(axis=1)


def one(x: np.ndarray) -> float:
    return float(bowl(x[None])[0])


def clipped(x: np.ndarray) -> np.ndarray:
    return np.minimum(np.maximum(x, 0.0), 1.0)


def plain_jaya(rng: np.random.Generator) -> float:
    x = [rng.random(D) for _ in range(N)]
    f = [one(p) for p in x]
    for _ in range(GENERATIONS):
        best, worst = x[int(np.argmin(f))].copy(), x[int(np.argmax(f))].copy()
        for i in range(N):
            trial = [
                x[i][j]
                + rng.random() * (best[j] - abs(x[i][j]))
                - rng.random() * (worst[j] - abs(x[i][j]))
                for j in range(D)
            ]
            trial = clipped(np.array(trial))
            if one(trial) <= f[i]:
                x[i], f[i] = trial, one(trial)
    return min(f)


def plain_tlbo(rng: np.random.Generator) -> float:
    x = [rng.random(D) for _ in range(N)]
    f = [one(p) for p in x]
    for _ in range(GENERATIONS):
        teacher, mean = x[int(np.argmin(f))].copy(), np.mean(x, axis=0)
        for i in range(N):
            factor = rng.integers(1, 3)
            trial = clipped(x[i] + rng.random(D) * (teacher - factor * mean))
            if one(trial) <= f[i]:
                x[i], f[i] = trial, one(trial)
        before, costs = [p.copy() for p in x], list(f)
        for i in range(N):
            j = int(rng.choice([k for k in range(N) if k != i]))
            step = before[i] - before[j] if costs[i] < costs[j] else before[j] - before[i]
            trial = clipped(before[i] + rng.random(D) * step)
            if one(trial) <= f[i]:
                x[i], f[i] = trial, one(trial)
    return min(f)


def plain_cuckoo(rng: np.random.Generator) -> float:
    beta = 1.5
    sigma = (
        math.gamma(1 + beta)
        * math.sin(math.pi * beta / 2)
        / (math.gamma((1 + beta) / 2) * beta * 2 ** ((beta - 1) / 2))
    ) ** (1 / beta)
    x = [rng.random(D) for _ in range(N)]
    f = [one(p) for p in x]

    def offer(i: int, trial: np.ndarray) -> None:
        if one(clipped(trial)) <= f[i]:
            x[i], f[i] = clipped(trial), one(clipped(trial))

    for _ in range(GENERATIONS):
        best = x[int(np.argmin(f))].copy()
        for i in range(N):
            s = rng.normal(0, sigma, D) / np.abs(rng.normal(size=D)) ** (1 / beta)
            offer(i, x[i] + 0.01 * s * (x[i] - best) * rng.normal(size=D))
        nests, p, q, r = [n.copy() for n in x], rng.permutation(N), rng.permutation(N), rng.random()
        for i in range(N):
            moved = rng.random(D) > 0.25
            offer(i, nests[i] + r * (nests[p[i]] - nests[q[i]]) * moved)
    return min(f)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("search", "plain", "each"),
    [(jaya.jaya, plain_jaya, 1), (tlbo.tlbo, plain_tlbo, 2), (cuckoo.cuckoo, plain_cuckoo, 2)],
)
def test_search_converges_as_a_plain_loop_of_its_definition(search, plain, each):
    method = Method("under test", "", search, "")
    budget = N * (1 + each * GENERATIONS)
    mine = [minimise(method, bowl, D, budget=budget, seed=s, n=N).cost for s in SEEDS]
    theirs = [plain(np.random.default_rng(1000 + s)) for s in SEEDS]
    assert stats.mannwhitneyu(np.log(mine), np.log(theirs)).pvalue > 0.01


@pytest.mark.parametrize("name", METHODS)
def test_every_method_keeps_its_budget_its_cube_and_its_seed(name):
    asked: list[np.ndarray] = []

    def spy(u: np.ndarray) -> np.ndarray:
        asked.append(u.copy())
        return bowl(u)

    first = minimise(name, spy, D, budget=777, seed=3)
    again = minimise(name, bowl, D, budget=777, seed=3)
    other = minimise(name, bowl, D, budget=777, seed=4)
    every = np.vstack(asked)
    assert len(every) == first.evaluations <= 777
    assert first.reason == "budget" or name == "pattern-search"
    assert every.min() >= 0.0
    assert every.max() <= 1.0
    assert first.cost == bowl(every).min() == one(first.best)
    assert np.array_equal(first.best, again.best)
    assert np.array_equal(first.history, again.history)
    assert not np.array_equal(first.best, other.best)
    assert (np.diff(first.history[:, 1]) <= 0).all()
    assert first.history[-1].tolist() == [first.evaluations, first.cost]


@pytest.mark.slow
@pytest.mark.parametrize("name", METHODS)
def test_every_method_improves_much_on_a_random_draw(name):
    draws = np.sort(bowl(np.random.default_rng(0).random((3000, D))))
    found = [minimise(name, bowl, D, budget=3000, seed=seed).cost for seed in range(5)]
    assert np.median(found) < 0.3 * draws[0]


@pytest.mark.slow
def test_candidates_that_cannot_be_simulated_are_survived():
    def broken(u: np.ndarray) -> np.ndarray:
        cost = bowl(u)
        cost[u[:, 0] > 0.7] = np.nan
        cost[u[:, 1] > 0.9] = np.inf
        return cost

    for name in METHODS:
        with np.errstate(all="raise", under="ignore"):
            found = minimise(name, broken, D, budget=600, seed=1)
        assert found.cost < 1.0, name


def test_a_target_ends_the_search_early():
    found = minimise("jaya", bowl, D, budget=100_000, seed=0, target=1e-3)
    assert found.reason == "target"
    assert found.cost <= 1e-3
    assert found.evaluations < 10_000


def test_a_budget_below_one_population_is_refused():
    with pytest.raises(UsageError, match="budget of 10 evaluations"):
        minimise("gwo", bowl, D, budget=10, seed=0)


def test_an_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(UsageError, match="de-best-1-bin"):
        get("de-best-1-bim")


def test_history_ends_the_search_at_the_single_evaluation():
    found = minimise("gwo", bowl, D, budget=100, seed=0)
    assert found.history[:, 0].tolist() == [30, 60, 90, 100]


def test_tent_map_stays_alive_and_covers_the_interval():
    points = chaos.tent_start(np.random.default_rng(0), 2000, 3)
    assert points.min() > 0.0
    assert points.max() < 1.0
    assert len(np.unique(points[:, 0])) == 2000
    # the skew tent map's invariant density is uniform
    assert stats.kstest(points[::7, 0], "uniform").pvalue > 0.01
    assert chaos.tent(np.array([0.35, 0.7, 0.85])).tolist() == pytest.approx([0.5, 1.0, 0.5])


def test_constants_are_the_published_ones():
    assert pytest.approx(0.7298, abs=5e-5) == pso.CHI
    assert pytest.approx(0.6966, abs=5e-5) == cuckoo.SIGMA
    assert chaos.MU == 0.7


@pytest.mark.parametrize(("search", "share"), [(cuckoo.cuckoo, 0.75), (cuckoo.cuckoo_25, 0.25)])
def test_the_cuckoos_switch_moves_that_share_of_components(search, share):
    population = Population(lambda u: np.zeros(len(u)), 50, 10**6, np.random.default_rng(0))
    population.begin(np.random.default_rng(1).random((40, 50)))
    flights = []
    evaluate = population.evaluate

    def spy(u: np.ndarray) -> np.ndarray:
        flights.append((u - population.u) != 0.0)
        return evaluate(u)

    population.evaluate = spy  # type: ignore[method-assign]
    next(search(population))
    assert abs(flights[1].mean() - share * 39 / 40) < 0.03  # permutations meet once in 40


def test_adaptive_inertia_by_its_definition():
    w = pso.adaptive_inertia(0.0, np.array([1.0, 2.0, 3.0, 6.0]))[:, 0]
    assert w.tolist() == pytest.approx([0.2, 0.7, 1.2, 1.2])
    assert np.isfinite(pso.adaptive_inertia(0.0, np.ones(3))).all()


def test_exponential_crossover_copies_one_cyclic_run():
    population = Population(bowl, 6, 10**6, np.random.default_rng(0))
    population.u = np.zeros((5000, 6))
    mask = exponential(population, 0.8)
    rises = (mask & ~np.roll(mask, 1, axis=1)).sum(axis=1)
    assert (rises[~mask.all(axis=1)] == 1).all()
    lengths = np.bincount(mask.sum(axis=1), minlength=7)[1:] / 5000
    expected = np.array([0.2 * 0.8**k for k in range(5)] + [0.8**5])
    assert np.abs(lengths - expected).max() < 0.02
    assert abs(mask.mean(axis=0) - mask.mean()).max() < 0.03  # it starts anywhere


def test_binomial_crossover_copies_one_component_at_least():
    population = Population(bowl, 6, 10**6, np.random.default_rng(0))
    population.u = np.zeros((5000, 6))
    assert (binomial(population, 0.0).sum(axis=1) == 1).all()
    assert abs(binomial(population, 0.5).mean() - (0.5 + 0.5 / 6)) < 0.02


@pytest.mark.slow
def test_others_are_distinct_uniform_and_not_the_row():
    rng = np.random.default_rng(0)
    seen = np.zeros((5, 5))
    for _ in range(2000):
        r1, r2, r3 = others(rng, 5, 3)
        for i in range(5):
            assert len({i, r1[i], r2[i], r3[i]}) == 4
            seen[i, r3[i]] += 1
    off_diagonal = seen[~np.eye(5, dtype=bool)]
    assert off_diagonal.min() > 430
    assert off_diagonal.max() < 570


def test_bounds_clip_redraw_and_bounce():
    u = np.array([[-0.2, 0.5, 1.3]])
    assert bounds.clip(u).tolist() == [[0.0, 0.5, 1.0]]
    redrawn = bounds.redraw(u, np.random.default_rng(0))
    assert redrawn[0, 1] == 0.5
    assert ((redrawn >= 0) & (redrawn <= 1)).all()
    x, v = bounds.bounce(u, np.array([[-0.4, 0.1, 0.6]]))
    assert x.tolist() == [[0.0, 0.5, 1.0]]
    assert v.tolist() == [[0.2, 0.1, -0.3]]


@pytest.mark.parametrize("log", [False, True])
def test_a_box_goes_there_and_back(log):
    box = bounds.Box.around({"R": 2.0, "L": 1e-3}, 0.1, 10.0, log)
    u = np.random.default_rng(0).random((20, 2))
    assert np.allclose(box.unit(box.physical(u)), u)
    assert box.physical(np.zeros(2)).tolist() == pytest.approx([0.2, 1e-4])
    assert box.physical(np.ones(2)).tolist() == pytest.approx([20.0, 1e-2])


def test_an_empty_box_is_refused():
    with pytest.raises(UsageError, match="bounds of R"):
        bounds.Box(("R",), np.array([2.0]), np.array([1.0]))


@pytest.mark.parametrize("memory", ["long", "short"])
@pytest.mark.parametrize("name", ["de-rand-1-exp", "pso", "abc"])
def test_memory_changes_no_answer_and_saves_simulations(name, memory):
    simulated = 0

    def f(u: np.ndarray) -> np.ndarray:
        nonlocal simulated
        simulated += len(u)
        return bowl(np.round(u, 2))

    plain = minimise(name, f, D, budget=2000, seed=5)
    simulated = 0
    cache = Cache(f, memory)
    helped = minimise(name, cache, D, budget=2000, seed=5)
    assert np.array_equal(plain.best, helped.best)
    assert cache.calls == 2000
    assert simulated == cache.calls - cache.hits
    assert 0.0 <= cache.hit_rate < 1.0


def test_memory_answers_repeats_within_and_across_calls():
    calls: list[int] = []

    def f(u: np.ndarray) -> np.ndarray:
        calls.append(len(u))
        return u.sum(axis=1)

    long, short = Cache(f, "long"), Cache(f, "short")
    a, b, c = (np.full((1, 2), x) for x in (0.1, 0.2, 0.3))
    for cache in (long, short):
        assert cache(np.vstack([a, a, b])).tolist() == pytest.approx([0.2, 0.2, 0.4])
        assert cache(b).tolist() == pytest.approx([0.4])
        assert cache(c).tolist() == pytest.approx([0.6])
        assert cache(c).tolist() == pytest.approx([0.6])
        assert cache(a).tolist() == pytest.approx([0.2])
    assert long.hits == 4  # a again, b, c, a
    assert short.hits == 3  # a was forgotten
    assert long.hit_rate == 4 / 7
