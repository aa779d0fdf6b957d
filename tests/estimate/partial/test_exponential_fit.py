"""How much less residuals tell that follow each other, against the theory of such noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from motorid.estimate.partial import exponential_fit
from motorid.estimate.partial.exponential_fit import _correlated


@pytest.mark.parametrize("rho", [0.5, 0.9])
def test_the_variance_of_a_mean_grows_as_of_an_autoregression(rho: float) -> None:
    noise = lfilter([1.0], [1.0, -rho], np.random.default_rng(2).standard_normal(40_000))
    assert _correlated(noise) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.1)


def test_white_residuals_tell_all_and_none_tell_no_less() -> None:
    assert _correlated(np.random.default_rng(2).standard_normal(2000)) == 1.0
    assert _correlated(np.zeros(50)) == 1.0


# rounding, weights and correlation, by their formulas


def test_readings_without_a_quantum_scatter_as_their_residuals() -> None:
    left = np.array([1.0, -2.0, 2.0, 1.0, 0.0, 0.0])
    found = exponential_fit.variances(left, np.arange(6.0), 0.0, 2)
    assert found == pytest.approx(10.0 / 4)
    exact = exponential_fit.variances(np.zeros(6), np.arange(6.0), 0.0, 2)
    assert exact == pytest.approx((1e-7 * 5.0) ** 2, rel=1e-6, abs=0.0)
    still = exponential_fit.variances(np.zeros(6), np.full(6, 3.0), 0.0, 2)
    assert still == pytest.approx(1e-14, rel=1e-6, abs=0.0)


def test_readings_of_one_quantum_share_what_noise_leaves_of_its_rounding() -> None:
    """q²/12 exp(-4π²σ²/q²) of each is common to all that round alike."""
    fitted = np.array([0.0, 0.1, 0.2, 0.9, 1.0, 1.1, 1.2, 2.0])  # cells of 3, 4 and 1
    q, sigma = 1.0, 0.2
    rng = np.random.default_rng(1)
    left = rng.standard_normal(8)
    left *= np.sqrt((q**2 / 12 + sigma**2) * 6 / (left @ left))
    found = exponential_fit.variances(left, fitted, q, 2)
    common = q**2 / 12 * np.exp(-4 * np.pi**2 * sigma**2 / q**2)
    own = q**2 / 12 + sigma**2 - common
    assert found == pytest.approx(np.repeat([3, 4, 1], [3, 4, 1]) * common + own)
    exact = exponential_fit.variances(np.zeros(8), fitted, q, 2)
    assert exact == pytest.approx(np.repeat([3, 4, 1], [3, 4, 1]) * q**2 / 12)


def test_neighbours_that_correlate_beyond_chance_widen() -> None:
    rng = np.random.default_rng(2)
    white = rng.standard_normal(2000)
    assert _correlated(white) == 1.0
    red = np.convolve(white, [1.0, 1.0], "valid")  # neighbours by one half
    assert _correlated(red) == pytest.approx(3.0, rel=0.1)
    assert _correlated(np.ones(900)) == pytest.approx((1 + 899 / 900) / 1.2e-3, rel=0.1)
    assert _correlated(np.tile([1.0, -1.0], 50)) == 1.0
    assert _correlated(np.zeros(10)) == 1.0


def test_weights_are_worth_their_sum_over_the_largest_one() -> None:
    assert exponential_fit._worth(np.sqrt([4.0, 2.0, 1.0, 1.0])) == pytest.approx(2.0)


def test_stamps_that_are_rounded_show_to_what() -> None:
    def quantum(steps: list[float]) -> float:
        time = np.concatenate([[0.0], np.cumsum(steps)])
        return exponential_fit.Record(time, time).stamp_quantum_s

    assert quantum([1.0e-3, 1.2e-3, 1.0e-3, 1.2e-3]) == pytest.approx(2e-4)
    assert quantum([1e-3] * 5) == 0.0
    assert quantum([1.0e-3, 1.1e-3, 1.3e-3, 1.7e-3]) == pytest.approx(1e-4)
    assert quantum([1.0e-3, 1.1e-3, 1.3e-3, 1.7e-3, 2.2e-3]) == 0.0  # they are no rounding


def made(lags: list[float], onsets: tuple[float | None, ...], covariance: np.ndarray,
         hidden: float = 0.0) -> exponential_fit.Rise:  # fmt: skip
    none = np.zeros(len(onsets))
    return exponential_fit.Rise(
        np.array(lags), onsets, none, none, covariance, 9, none, 1.0, (), 1, hidden
    )


def test_a_sum_of_lags_has_the_variance_of_a_sum_and_of_what_may_hide() -> None:
    covariance = np.diag([4.0, 1.0, 9.0, 16.0, 1.0, 1.0, 1.0, 1.0])
    covariance[0, 1] = covariance[1, 0] = -1.5
    both = made([0.5, 0.1], (None, 0.3), covariance[:7, :7], 0.5)
    assert both.constant_s == pytest.approx(0.6)
    assert both.constant_variance == pytest.approx(4.0 + 1.0 - 3.0 + 0.25)
    assert both.lag_variance == 4.0
    assert both.onset_variance(1) == 9.0
    one = made([0.5], (0.2, None, 0.3), np.diag([2.0, 3.0, 5.0, 1, 1, 1, 1, 1, 1]))
    assert (one.onset_variance(0), one.onset_variance(2)) == (3.0, 5.0)
    assert [one.place(k) for k in range(3)] == [6, 7, 8]
    alike = made([0.5, 0.1], (None,), np.array([[1.0, 3.0, 0], [3.0, 1.0, 0], [0, 0, 1.0]]))
    assert alike.lag_variance == pytest.approx(8.0)


@pytest.mark.parametrize(("onset", "shown"), [(0.5, True), (0.0, False)])
def test_an_onset_is_shown_where_a_reading_lies_before_it(onset: float, shown: bool) -> None:
    time = 0.1 * np.arange(60)
    values = 3.0 * (1.0 - np.exp(-np.maximum(time - onset, 0.0) / 0.8))
    found = exponential_fit._start(exponential_fit.Record(time, values))
    assert found.shown is shown
    between = 3.0 * (1.0 - np.exp(-np.maximum(time - 0.05, 0.0) / 0.8))
    half = exponential_fit._start(exponential_fit.Record(time, between))
    assert (half.onset_s, half.shown) == (pytest.approx(0.05), True)
