"""The review's experiments, rebuilt: the figures that the recovered set-ups promise."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from motorid.estimate.assembly.assemble import fit
from motorid.search.review import tables
from motorid.search.review.as_capture import capture_of
from motorid.search.review.experiment import Experiment, Row
from motorid.search.review.run import figures_found, relative_to_estimate, run, summarise
from motorid.search.review.tables import PERCENT_ORDER, table

# Medians of 11 trials on Motor 2 with weight 100, recovered before this code was written: percent
# of the estimate, R K L J B, by population (30 x 100 and 20 x 50 iterations).
DEAR = {("cuckoo-m", 20)}  # as "cuckoo"
RECOVERED = {
    ("gwo", 30): (0.18, 0.08, 0.22, 0.23, 0.13),
    ("gwo-m", 30): (0.04, 0.009, 0.67, 0.82, 0.009),
    ("jaya", 30): (0.02, 0.01, 0.10, 0.02, 0.02),
    ("jaya-m", 30): (0.058, 0.013, 0.664, 0.823, 0.013),
    ("cuckoo", 30): (1.1, 0.26, 1.0, 1.5, 0.7),
    ("cuckoo-m", 30): (0.04, 0.009, 0.16, 0.045, 0.009),
    ("cuckoo-m-peak", 30): (0.058, 0.013, 0.666, 0.823, 0.013),
    ("gwo", 20): (0.5, 0.2, 1.5, 0.2, 0.8),
    ("jaya", 20): (0.6, 0.2, 1.4, 0.6, 0.5),
    ("cuckoo", 20): (6.2, 2.1, 8.2, 8.6, 3.1),
    ("cuckoo-m", 20): (0.4, 0.09, 2.1, 0.8, 0.09),
}
ITERATIONS = {30: 100, 20: 50}


def experiment(key: str) -> Experiment:
    number = int(key.split("-")[0])
    return next(e for e in table(number) if e.key == key)


def row(of: Experiment, label: str) -> Row:
    return next(r for r in of.rows if r.label == label)


def errors(of: Experiment, which: Row, noise: float, seeds: int, estimate: bool = False):
    summary = summarise(of, which, noise, [run(of, which, noise, seed) for seed in range(seeds)])
    chosen = summary.to_estimate if estimate else summary.to_nominal
    return {name: q.median for name, q in chosen.items()}


TRIALS = 11  # behind each recovered median
CLOSE = 1.1  # a ratio that two digits of a median do not show
IMPROBABLE = 1e-3  # of 55 medians, one in twenty times


@cache
def misses(method: str, n: int) -> dict[str, np.ndarray]:
    """Percent errors over 60 seeds, relative to the estimate, by parameter."""
    of = experiment("9-w100")
    each = 2 if method.startswith("cuckoo") else 1
    trial = Row("trial", method, n * (1 + each * ITERATIONS[n]), n, "printed")
    found = figures_found(of, [run(of, trial, 0.0, seed) for seed in range(60)])
    return {p: relative_to_estimate(found[p], np.array(of.truth[p])) for p in PERCENT_ORDER}


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize(
    ("method", "n"),
    [
        pytest.param(*one, marks=[pytest.mark.study] if one[1] >= 30 or one in DEAR else [])
        for one in RECOVERED
    ],
)
def test_medians_of_table_9_are_the_recovered_ones(method, n):
    """Within a factor of 2 over the five parameters together, and each could be of our runs.

    Medians of 11 trials scatter themselves, by a factor of 2 or 3 where a search has not ended.
    """
    rng, ratios = np.random.default_rng(0), []
    for name, recovered in zip(PERCENT_ORDER, RECOVERED[method, n], strict=True):
        ours = misses(method, n)[name]
        ratios.append(float(np.median(ours)) / recovered)
        medians = np.median(rng.choice(ours, (10_000, TRIALS)), axis=1)
        below, above = medians <= CLOSE * recovered, medians >= recovered / CLOSE
        assert 2.0 * min(below.mean(), above.mean()) > IMPROBABLE, (name, ratios)
    assert np.exp(np.abs(np.log(ratios)).mean()) < 2.0, ratios


@pytest.mark.slow
@pytest.mark.study
def test_nine_tenths_of_the_recovered_medians_are_within_a_factor_of_two():
    ratios = [
        np.median(misses(*key)[name]) / recovered
        for key, medians in RECOVERED.items()
        for name, recovered in zip(PERCENT_ORDER, medians, strict=True)
    ]
    assert np.mean(np.abs(np.log(ratios)) < np.log(2.0)) >= 0.9


@pytest.mark.slow
def test_jaya_m_of_table_9_prints_its_floor_and_loses_it_with_the_exact_rule():
    of = experiment("9-w100")
    by_printed = errors(of, row(of, "Test 4 Jaya_m"), 0.0, 5, estimate=True)
    by_exact = errors(of, row(of, "Test 4 Jaya_m, exact rule"), 0.0, 5, estimate=True)
    assert by_printed["J"] == pytest.approx(0.809, rel=0.02)
    assert by_exact["J"] < 0.001
    assert row(of, "Test 4 Jaya_m").printed["J"] == 0.809


@pytest.mark.slow
def test_at_weight_one_only_the_modified_searches_converge():
    of = experiment("9-w1")
    original = errors(of, row(of, "Test 3 GWO_o"), 0.0, 5, estimate=True)
    modified = errors(of, row(of, "Test 3 Jaya_m"), 0.0, 5, estimate=True)
    assert min(original["R"], original["L"], original["J"]) > 5.0
    floor = {"R": 0.74, "K": 0.166, "L": 0.803, "J": 0.977}
    for name, value in floor.items():
        assert modified[name] == pytest.approx(value, rel=0.01), name


@pytest.mark.slow
@pytest.mark.study
def test_de_rand_1_exp_solves_the_staircase_of_table_4():
    of = experiment("4-staircase")
    found = errors(of, row(of, "DE/rand/1/exp"), 0.0, 5)
    assert len(found) == 7
    assert max(found.values()) < 0.1
    assert max(errors(of, row(of, "GA"), 0.0, 3).values()) > 5.0


@pytest.mark.slow
def test_one_step_of_table_4_hides_the_load():
    of = experiment("4-step")
    found = errors(of, row(of, "DE/rand/1/exp"), 0.0, 5)
    assert max(found[name] for name in ("R", "L", "c", "J")) < 0.05
    assert max(found[name] for name in ("Ta", "Tb", "Tc")) > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("label", ["CIW PSO", "CI PSO"])
def test_a_random_binary_torque_makes_table_5_right(label):
    of = experiment("5-prbs")
    assert max(errors(of, row(of, label), 0.0, 11).values()) < 1.0
    step = experiment("5-step")
    assert max(errors(step, row(step, label), 0.0, 11).values()) > 5.0


@pytest.mark.slow
def test_steiglitz_mcbride_is_exact_on_table_7_without_noise():
    of = experiment("7")
    assert max(errors(of, row(of, "Steiglitz-McBride"), 0.0, 1).values()) < 1e-6
    noisy = errors(of, row(of, "Steiglitz-McBride"), 0.01, 5)
    assert 1e-3 < max(noisy.values()) < 10.0


@pytest.mark.slow
def test_speed_alone_finds_three_numbers_of_table_6_and_not_five():
    of = experiment("6-speed")
    found = errors(of, row(of, "NLS (ours)"), 0.0, 3)
    assert max(found[name] for name in ("n0", "a1", "a0")) < 1e-6
    assert min(found[name] for name in ("R", "L", "K", "J")) > 1.0
    both = experiment("6-both")
    assert max(errors(both, row(both, "NLS (ours)"), 0.0, 3).values()) < 1e-3


@pytest.mark.slow
def test_closed_forms_of_table_3():
    of = experiment("3")
    for label in ("Acceleration", "Least squares"):
        clean = errors(of, row(of, label), 0.0, 1)
        noisy = errors(of, row(of, label), 0.01, 8)
        assert max(clean.values()) < 0.2, label
        assert max(noisy.values()) < 15.0, label
    assert "L" not in clean


EXACT = ["2", "3", "4-staircase", "5-prbs", "6-both", "7", "8-w100", "9-w100"]


@pytest.mark.slow
@pytest.mark.parametrize("key", EXACT)
def test_the_default_estimator_is_exact_without_noise(key):
    of = experiment(key)
    first = of.rows[0]
    assert first.method == "ml"
    solution = run(of, first, 0.0, 0)
    assert max(errors(of, first, 0.0, 1).values()) < 1e-3
    populations = [r.budget for r in of.rows if r.n]
    assert not populations or solution.evaluations * 50 <= min(populations)


@pytest.mark.slow
def test_a_back_emf_below_the_noise_is_no_reversed_encoder():
    """Table 6 has K²/(RB) = .001: with 1 % noise its ratios are known, and K alone is not."""
    of = experiment("6-both")
    estimate = fit([capture_of(of.problem(0.01, 0).step)], without=("T0",))
    assert estimate.parameters["K"].status == "not_identifiable"
    ratio = estimate.combinations["B/K"]
    assert ratio.value == pytest.approx(of.truth["B"] / of.truth["K"], rel=0.01)


def test_noise_is_white_of_the_stated_size_and_repeatable():
    of = experiment("3")
    clean = of.clean()
    first, again, other = (of.problem(0.01, seed).step for seed in (4, 4, 5))
    for name, share in (("current", 0.005), ("speed", 0.002)):
        noise = first.measured[name] - clean.measured[name]
        assert np.std(noise) == pytest.approx(share * np.abs(clean.measured[name]).max(), rel=0.1)
        assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.1
        assert np.array_equal(first.measured[name], again.measured[name])
        assert not np.array_equal(first.measured[name], other.measured[name])


def test_printed_figures_name_parameters_of_their_models():
    for number in tables.TABLES:
        for of in table(number):
            for which in of.rows:
                assert set(which.printed) <= set(of.truth) | {"Ke", "Kt"}, which.label
                if which.percent:
                    assert tuple(which.printed) == PERCENT_ORDER


@pytest.mark.slow
def test_the_default_estimator_is_as_good_as_the_best_method_of_table_2():
    of = experiment("2")
    rms = {}
    for which in of.rows[:2]:
        runs = [run(of, which, 0.01, seed) for seed in range(40)]
        rms[which.method] = summarise(of, which, 0.01, runs).rms
    for name, best in rms["nls"].items():
        assert rms["ml"][name] <= 1.03 * best, name
