"""Autoregressive models against Yule-Walker solved by scipy, and processes that are known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

from motorid.estimate.solver.autoregression import (
    LARGEST_ORDER,
    autocovariance,
    autoregression,
    fast_length,
    power,
    prominence,
    whitener,
)

Floats = NDArray[np.float64]


def process(n: int, *coefficients: float, seed: int = 1) -> Floats:
    """r[t] = Σ c r[t-k] + e[t], past its beginning."""
    e = np.random.default_rng(seed).standard_normal(n + 500)
    return np.asarray(lfilter([1.0], [1.0, *(-c for c in coefficients)], e))[500:]


def test_the_autocovariance_is_the_biased_one_about_zero() -> None:
    r = process(300, 0.5) + 2.0
    wanted = [float(np.sum(r[: 300 - k] * r[k:])) / 300 for k in range(4)]
    assert autocovariance(r, 3) == pytest.approx(wanted)


@pytest.mark.parametrize("coefficients", [(0.8,), (1.2, -0.5), (0.3, 0.0, 0.4)])
def test_coefficients_are_those_of_yule_and_walker_at_the_order_of_the_process(
    coefficients: tuple[float, ...],
) -> None:
    r = process(20_000, *coefficients)
    found, innovation = autoregression(r)
    assert len(found) == len(coefficients)
    lags = autocovariance(r, len(coefficients))
    assert found == pytest.approx(solve_toeplitz(lags[:-1], lags[1:]))
    assert innovation == pytest.approx(lags[0] - found @ lags[1:])
    assert found == pytest.approx(coefficients, abs=0.03)
    assert innovation == pytest.approx(1.0, rel=0.03)


def test_the_order_is_schwarzs() -> None:
    r = process(2000, 0.9, -0.3, 0.1)
    lags = autocovariance(r, LARGEST_ORDER)
    criteria = [2000 * np.log(lags[0])]
    for order in range(1, LARGEST_ORDER + 1):
        c = solve_toeplitz(lags[:order], lags[1 : order + 1])
        criteria.append(2000 * np.log(lags[0] - c @ lags[1 : order + 1]) + order * np.log(2000))
    assert len(autoregression(r)[0]) == int(np.argmin(criteria))


def test_white_noise_has_none_and_needs_no_filter() -> None:
    r = process(5000)
    found, innovation = autoregression(r)
    assert len(found) == 0
    assert innovation == pytest.approx(float(np.mean(r**2)))
    assert whitener(r) is None
    assert prominence(r) == 1.0


def test_several_stretches_count_by_their_lengths() -> None:
    long, short = process(4000, 0.8), 3.0 * process(1000, 0.8, seed=2)
    lags = (4000 * autocovariance(long, 1) + 1000 * autocovariance(short, 1)) / 5000
    found, innovation = autoregression(long, short)
    assert found == pytest.approx([lags[1] / lags[0]])
    assert innovation == pytest.approx(lags[0] * (1 - (lags[1] / lags[0]) ** 2))


def test_what_is_short_has_a_low_order_or_none() -> None:
    assert len(autoregression(process(7, 0.9))[0]) == 0
    few = process(7, 0.9)
    assert autoregression(few)[1] == pytest.approx(float(np.mean(few**2)))
    assert len(autoregression(process(4000, 0.9), process(15, 0.9))[0]) <= 1
    assert len(autoregression(process(4000, 0.9), process(8, 0.9))[0]) == 1
    assert len(autoregression(process(4000, 0.9), process(7, 0.9))[0]) == 0
    assert len(autoregression(process(4000, 1.2, -0.5), process(15, 0.9))[0]) == 1
    none, nothing = autoregression(np.zeros(0))
    assert (len(none), nothing) == (0, 0.0)


def test_nothing_at_all_has_no_process() -> None:
    found, innovation = autoregression(np.zeros(200))
    assert len(found) == 0
    assert innovation == 0.0


@pytest.mark.slow
@given(st.floats(-0.9, 0.9), st.floats(0.1, 9.0))
def test_the_mean_of_the_spectrum_is_the_variance(c: float, innovation: float) -> None:
    size = 4096
    half = power(np.array([c]), innovation, size)
    whole = np.concatenate([half, half[-2:0:-1]])
    assert len(whole) == size
    assert whole.mean() == pytest.approx(innovation / (1 - c**2), rel=1e-6)


def test_a_spectrum_is_highest_at_rest_where_neighbours_are_alike() -> None:
    """Σ c[k] at rest, Σ c[k] (-1)^k at half the rate of the readings."""
    found = power(np.array([0.5, -0.2]), 3.0, 64)
    assert found[0] == pytest.approx(3.0 / (1 - 0.5 + 0.2) ** 2)
    assert found[-1] == pytest.approx(3.0 / (1 + 0.5 + 0.2) ** 2)


def test_prominence_is_the_top_over_the_mean() -> None:
    """Of a first order: (1 + c)/(1 - c), nearly, by its power at rest over its variance."""
    for c in (0.3, 0.5, 0.8):
        r = process(50_000, c)
        assert prominence(r) == pytest.approx((1 + c) / (1 - c), rel=0.1)


def test_a_whitened_process_is_white() -> None:
    r = process(20_000, 1.2, -0.5)
    taps = whitener(r)
    assert taps is not None
    assert taps[0] == 1.0
    left = lfilter(taps, [1.0], r)[10:]
    lags = autocovariance(np.asarray(left), 5)
    assert np.abs(lags[1:] / lags[0]).max() < 4 / np.sqrt(20_000)


@pytest.mark.parametrize(("c", "filtered"), [(0.28, False), (0.4, True)])
def test_a_spectrum_is_worth_whitening_from_twice_its_mean(c: float, filtered: bool) -> None:
    """(1 + c)/(1 - c): 1.78 and 2.33."""
    assert (whitener(process(50_000, c)) is not None) is filtered


@pytest.mark.parametrize(("least", "length"), [(1, 1), (2, 2), (3, 4), (64, 64), (65, 128)])
def test_a_fast_length_is_the_next_power_of_two(least: int, length: int) -> None:
    assert fast_length(least) == length


def test_stretches_too_short_for_an_order_have_their_mean_square() -> None:
    for stretches in ([[3.0]], [[1.0, -2.0, 2.0]], [[2.0], [4.0, 1.0]]):
        arrays = [np.array(one) for one in stretches]
        coefficients, innovation = autoregression(*arrays)
        assert coefficients.shape == (0,)
        assert innovation == pytest.approx(np.mean(np.concatenate(arrays) ** 2))
