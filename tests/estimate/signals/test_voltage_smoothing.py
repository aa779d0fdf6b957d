"""Readings freed of noise over windows that they ask for, beside jumps as well."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from motorid.estimate.signals import voltage_smoothing
from motorid.estimate.signals.voltage_jumps import scatter
from motorid.estimate.signals.voltage_smoothing import HALF_WINDOWS, calm_windows, smoothed
from tests.estimate.signals.quieted import quiet

Floats = NDArray[np.float64]
NOISE_V = 0.01


def noisy(true: Floats, seed: int) -> Floats:
    return true + NOISE_V * np.random.default_rng(seed).standard_normal(len(true))


def rms(x: Floats) -> float:
    return float(np.sqrt(np.mean(x**2)))


@pytest.mark.slow
def test_beside_a_jump_readings_are_freed_of_noise_too() -> None:
    """Of 30 logs, and none is moved one way."""
    true = np.repeat([0.0, 6.0, 2.0], 200)
    left = np.array([quiet(noisy(true, seed)) - true for seed in range(30)])
    for beside in (slice(200, 208), slice(192, 200), slice(400, 408)):
        assert rms(left[:, beside]) < 0.6 * NOISE_V
        assert abs(float(left[:, beside].mean())) < 0.1 * NOISE_V


def test_where_nothing_jumps_windows_lie_about_their_readings() -> None:
    """To the side of a curve's sharpest bends a parabola would be off."""
    place = np.arange(2000.0)
    for true in (12.0 - np.abs(place - 1000.0) * 0.01, 6.0 * np.sin(place**2 * 2e-5)):
        assert not calm_windows(noisy(true, 2)).ahead.any()


def test_a_reading_s_window_lies_on_its_own_side_of_a_jump() -> None:
    found = calm_windows(noisy(np.repeat([0.0, 6.0, 2.0], 200), 1))
    at = np.arange(600)
    first, last = at + found.ahead - found.half, at + found.ahead + found.half
    assert (first >= at // 200 * 200).all()
    assert (last < (at // 200 + 1) * 200).all()
    assert (np.abs(found.ahead) <= found.half).all()
    assert found.ahead[200] > 0 > found.ahead[199]


@pytest.mark.slow
@given(st.integers(0, 9), st.floats(-4.0, 4.0), st.floats(-0.1, 0.1), st.floats(-1e-3, 1e-3))
def test_a_parabola_stays_what_it_is(seed: int, a: float, b: float, c: float) -> None:
    """Whatever windows readings ask for, those of a parabola give it back."""
    place = np.arange(300.0)
    windows = calm_windows(noisy(np.repeat([0.0, 3.0], 150), seed))
    true = a + b * place + c * place**2
    assert smoothed(true, windows) == pytest.approx(true, abs=1e-8)


@pytest.mark.parametrize("half", [2, 4, 16])
@pytest.mark.parametrize("ahead", [0, 1, 2])
def test_the_share_that_is_left_is_that_of_least_squares(half: int, ahead: int) -> None:
    table = np.vander(np.arange(-half, half + 1.0), 3)
    row = np.array([ahead**2, -ahead, 1.0])
    told = row @ np.linalg.inv(table.T @ table) @ row
    assert voltage_smoothing._share(half, np.array([ahead])) == pytest.approx([told])


def test_without_noise_nothing_is_changed() -> None:
    volts = np.repeat([0.0, 6.0, 2.0], 100)
    assert scatter(volts) == 0.0
    assert quiet(volts).tolist() == volts.tolist()
    assert quiet(volts[:5]).tolist() == volts[:5].tolist()


@pytest.mark.parametrize("half", HALF_WINDOWS)
def test_a_window_s_parabola_is_that_of_least_squares(half: int) -> None:
    volts = 5.0 + np.random.default_rng(3).standard_normal(2 * half + 8)
    values, slopes, bends = voltage_smoothing._parabolas(volts, half)
    left = voltage_smoothing._spread(volts, half)
    place = np.arange(-half, half + 1.0)
    assert len(values) == 8
    for k in range(8):
        here = volts[k : k + 2 * half + 1]
        fitted = np.polynomial.Polynomial.fit(place, here, 2)
        off = here - fitted(place)
        assert values[k] == pytest.approx(fitted(0.0))
        assert values[k] + slopes[k] + bends[k] == pytest.approx(fitted(1.0))
        assert values[k] - 2.0 * slopes[k] + 4.0 * bends[k] == pytest.approx(fitted(-2.0))
        assert left[k] == pytest.approx(float(off @ off) / (2 * half + 1 - 3))


def test_small_noise_hides_no_small_jump() -> None:
    """One of .2 V beside .01 V of noise stays as sharp as it was read."""
    rng = np.random.default_rng(4)
    true = np.where(np.arange(400) < 200, 0.0, 0.2)
    read = true + 0.01 * rng.standard_normal(400)
    left = quiet(read) - true
    assert np.abs(left[190:210]).max() < 0.05
    assert np.std(left[50:150]) < 0.005


def test_a_bend_that_noise_does_not_explain_is_kept() -> None:
    """A wave of 24 readings, .3 V high, beside .01 V of noise: no wide parabola follows it."""
    rng = np.random.default_rng(6)
    true = 0.3 * np.sin(2.0 * np.pi * np.arange(600) / 24.0)
    left = quiet(true + 0.01 * rng.standard_normal(600)) - true
    assert np.abs(left).max() < 0.06
