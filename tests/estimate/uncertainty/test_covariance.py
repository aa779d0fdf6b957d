"""Covariances against what simulation and theory say they must be."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from motorid.estimate.solver.autoregression import autoregression, power, whitener
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Block, Linearised, Solution, Unknown
from motorid.estimate.uncertainty.between_run_variance import spread_of
from motorid.estimate.uncertainty.covariance import (
    NOISE,
    SPREAD,
    Known,
    Statistical,
    covariance_of,
    score_covariance,
    statistical,
)
from motorid.estimate.uncertainty.intervals import Findings
from tests.estimate.solutions import OneByOne

N = 2000


class Level(OneByOne):
    """A constant under noise."""

    unknowns = ()
    simulated = 0

    def __init__(self, noise: np.ndarray) -> None:
        self.y = 5.0 + noise
        self.blocks = (Block("y", 1e-9, len(noise), "y"),)

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        return [self.y - shared[0]]


def solve(*noises: np.ndarray) -> Solution:
    return maximise([Unknown("level", 4.0)], [Level(noise) for noise in noises])


def test_nothing_unknown_has_no_covariance() -> None:
    assert covariance_of(np.zeros((0, 0))).shape == (0, 0)


def test_white_noise_is_left_alone() -> None:
    noise = np.random.default_rng(1).standard_normal(N)
    found = statistical(solve(noise))
    assert found.deviations[0] == pytest.approx(1 / np.sqrt(N), rel=0.05)
    assert found.coloured < 1.05
    assert whitener(noise) is None


def test_scores_of_correlated_noise_have_the_covariance_of_its_process() -> None:
    """Of derivatives A, A' C A with C of the residuals' own autoregression."""
    rng = np.random.default_rng(12)
    left = lfilter([1.0], [1.0, -0.7], rng.standard_normal(300))
    slopes = np.cumsum(rng.standard_normal((300, 2)), axis=0)
    line = Linearised(
        left, slopes, np.zeros((300, 0)), slopes, np.zeros(0), (), (slice(0, 300),), np.ones(1)
    )
    coefficients, innovation = autoregression(left)
    assert len(coefficients)
    ringing = lfilter([1.0], np.concatenate([[1.0], -coefficients]), np.eye(1, 3000)[0])
    lags = np.array([ringing[: 3000 - k] @ ringing[k:] for k in range(300)]) * innovation
    expected = slopes.T @ toeplitz(lags) @ slopes
    np.testing.assert_allclose(score_covariance(line), expected, rtol=1e-6)


def test_correlated_noise_widens_as_theory_says() -> None:
    rng = np.random.default_rng(3)
    noise = lfilter([1.0], [1.0, -0.8], rng.standard_normal(N))
    found = statistical(solve(noise))
    assert found.deviations[0] == pytest.approx(1 / 0.2 / np.sqrt(N), rel=0.15)


@pytest.mark.slow
def test_means_of_correlated_noise_scatter_by_the_stated_deviation() -> None:
    rng = np.random.default_rng(3)
    pulls = []
    for _ in range(150):
        noise = lfilter([1.0, 0.5], [1.0, -0.7], rng.standard_normal(600))
        solution = solve(noise)
        pulls.append((solution.values[0] - 5.0) / statistical(solution).deviations[0])
    assert np.std(pulls) == pytest.approx(1.0, abs=0.15)


def test_autoregression_finds_order_and_spectrum() -> None:
    noise = lfilter([1.0], [1.0, -1.2, 0.5], np.random.default_rng(4).standard_normal(20_000))
    coefficients, innovation = autoregression(noise)
    np.testing.assert_allclose(coefficients[:2], [1.2, -0.5], atol=0.03)
    assert innovation == pytest.approx(1.0, rel=0.03)
    assert power(coefficients, innovation, 4096).mean() == pytest.approx(noise.var(), rel=0.1)


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_unit_of_a_reading_changes_no_correlation(unit: float) -> None:
    noise = lfilter([1.0], [1.0, -0.8], np.random.default_rng(4).standard_normal(2000))
    coefficients, innovation = autoregression(noise)
    scaled, largest = autoregression(unit * noise)
    assert len(coefficients) > 0
    np.testing.assert_allclose(scaled, coefficients, rtol=1e-6)
    assert largest == pytest.approx(unit**2 * innovation, rel=1e-6)


def test_a_whitener_leaves_white_noise() -> None:
    noise = np.cumsum(np.random.default_rng(5).standard_normal(N))
    taps = whitener(noise)
    assert taps is not None
    left = np.convolve(noise, taps, "valid")
    assert abs(np.corrcoef(left[1:], left[:-1])[0, 1]) < 0.1


def test_three_runs_show_their_spread() -> None:
    rng = np.random.default_rng(6)
    offsets = (0.0, 0.4, -0.5)
    found = statistical(solve(*(o + 0.1 * rng.standard_normal(500) for o in offsets)))
    assert found.between_runs
    assert found.deviations[0] == pytest.approx(np.std(offsets, ddof=1) / np.sqrt(3), rel=0.1)
    assert found.freedom[0] == pytest.approx(2.0, rel=0.1)


def test_parts_of_runs_show_theirs() -> None:
    rng = np.random.default_rng(8)
    offsets = rng.standard_normal((3, 4))
    offsets -= offsets.mean(axis=1)[:, None]  # runs agree
    parts = [rng.permutation(np.repeat(np.arange(4), 200)) for _ in offsets]  # no colour
    noise = 0.01 * rng.standard_normal((3, 800))
    runs = [row[part] + e for row, part, e in zip(offsets, parts, noise, strict=True)]
    found = statistical(solve(*runs), parts=parts)
    assert found.deviations[0] == pytest.approx(np.std(offsets, ddof=1) / np.sqrt(12), rel=0.01)
    assert found.freedom[0] == pytest.approx(11.0, rel=0.02)
    assert statistical(solve(*runs)).freedom[0] > 11.0  # which the runs alone do not show


def test_white_noise_spreads_by_its_own_variance_however_little_a_cluster_tells() -> None:
    rng = np.random.default_rng(9)
    columns = rng.standard_normal((300, 2)) * [[1.0, 0.2]]
    columns[:40] *= 5.0  # one cluster tells most
    edges = [0, 40, 60, 120, 200, 230, 300]
    inverse = np.linalg.inv(columns.T @ columns)
    spreads = []
    for _ in range(600):
        noise = rng.standard_normal(300)
        left = noise - columns @ (inverse @ (columns.T @ noise))
        clusters = [slice(a, b) for a, b in pairwise(edges)]
        pulls = [(columns[c].T @ left[c], columns[c].T @ columns[c]) for c in clusters]
        spreads.append(spread_of(pulls, inverse)[0])
    np.testing.assert_allclose(np.mean(spreads, axis=0), np.diag(inverse), rtol=0.1)


def test_two_runs_do_not() -> None:
    rng = np.random.default_rng(7)
    found = statistical(solve(*(0.1 * rng.standard_normal(500) for _ in range(2))))
    assert not found.between_runs


@pytest.mark.parametrize(
    ("instrument", "freedom"),
    [(0.0, 2.0), (1.0, 8.0), (3.0, 200.0)],  # 2 (1 + instrument²)²
)
def test_what_instruments_share_needs_no_student_factor(instrument: float, freedom: float) -> None:
    spread = Statistical(np.eye(1), np.array([2.0]), coloured=1.0, between_runs=True)
    found = Findings(solve(np.zeros(9)), spread, {"gain": np.array([instrument])}, {}, ())
    assert found.propagate(np.ones(1)) == pytest.approx((1.0, instrument, freedom))


@pytest.mark.parametrize(
    "information",
    [
        np.zeros((2, 2)),
        np.array([[1e-120, 0.0], [0.0, 4.0]]),
        np.array([[-1e-9, 3e180], [3e180, 4.0]]),  # what rounding may leave of a huge one
    ],
)
def test_what_nobody_can_see_has_a_large_variance_that_is_still_a_number(
    information: np.ndarray,
) -> None:
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        found = covariance_of(information)
        squared = found @ np.eye(2) @ found
    assert np.isfinite(squared).all()
    assert found[0, 0] > 1e90
    if information[0, 1] == 0.0 and information[1, 1]:
        assert found[1, 1] == pytest.approx(0.25)


def test_the_spread_between_runs_is_a_line_where_they_scatter_more_than_their_noise() -> None:
    rng = np.random.default_rng(11)
    noises = [0.1 * rng.standard_normal(500) for _ in range(3)]
    noises = [noise - noise.mean() for noise in noises]  # runs agree to the last digit
    alike = statistical(solve(*noises))
    assert set(alike.lines) == {NOISE}
    apart = statistical(solve(*(o + n for o, n in zip((0.0, 0.4, -0.5), noises, strict=True))))
    assert set(apart.lines) == {NOISE, SPREAD}
    assert sum(apart.lines.values()) == pytest.approx(np.diag(apart.covariance))


def test_what_priors_and_unseen_noise_leave_open_are_lines_of_their_own() -> None:
    solution = solve(np.random.default_rng(12).standard_normal(400))
    shifts = {"gain": np.array([[0.3]]), "clock": np.array([[0.1]]), "none": np.zeros((0, 1))}
    found = statistical(solution, Known(shifts), {"gain": [np.array([0.4])]})
    assert set(found.lines) == {NOISE, "gain", "clock"}
    assert found.lines["gain"] == pytest.approx([0.3**2 + 0.4**2])
    assert found.lines["clock"] == pytest.approx([0.1**2])
    assert sum(found.lines.values()) == pytest.approx(np.diag(found.covariance))
