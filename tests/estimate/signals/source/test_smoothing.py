"""Curves of a source beyond its line, on signals of which all is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.estimate.signals.source.smoothing import (
    ALWAYS,
    AS_READ,
    LINE,
    PLAIN,
    Form,
    smoothed,
    trend_of,
)
from motorid.estimate.signals.source.step_transient import HEAD

N = 400
NOISE = 1e-4  # variance


def noise(seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, NOISE**0.5, N)


@pytest.mark.slow
@given(st.integers(1, 30), st.integers(0, 12))
def test_a_mean_over_neighbours_by_counting(n: int, half: int) -> None:
    values = np.random.default_rng(n).normal(size=n)
    expected = [values[max(k - half, 0) : k + half + 1].mean() for k in range(n)]
    assert smoothed(values, half) == pytest.approx(expected, abs=1e-12)


def test_noise_about_a_line_has_no_curve() -> None:
    trend, form = trend_of(noise(), NOISE, 1.5 * NOISE)
    assert form.half == LINE
    assert not trend.any()
    assert form.quiet
    assert Form() == PLAIN


def test_a_slow_bow_is_followed_and_its_noise_is_not() -> None:
    bow = 0.1 * np.sin(np.linspace(0.0, 2 * np.pi, N))
    trend, form = trend_of(bow + noise(), NOISE, 1.5 * NOISE)
    assert form.half > 0
    inner = slice(HEAD + 20, -20)
    assert np.abs(trend - bow)[inner].max() < 3 * NOISE**0.5
    assert np.std((trend - bow)[inner]) < 0.5 * NOISE**0.5


def test_what_no_window_follows_is_taken_as_read() -> None:
    jumps = 0.2 * np.sign(np.sin(np.arange(N) * 1.3))
    trend, form = trend_of(jumps + noise(), NOISE, 1.5 * NOISE)
    assert form.half == AS_READ
    assert not form.quiet
    assert trend[HEAD:] == pytest.approx((jumps + noise())[HEAD:])


def test_odd_first_samples_are_a_head() -> None:
    left = noise()
    left[:5] += 0.2
    assert trend_of(left, NOISE, 1.5 * NOISE)[1].head == 5
    assert trend_of(noise(), NOISE, 1.5 * NOISE)[1].head == ALWAYS


def test_a_form_that_is_given_stays() -> None:
    form = Form(16, 2)
    trend, same = trend_of(noise(), NOISE, 1.5 * NOISE, form=form)
    assert same is form
    assert trend[HEAD:] == pytest.approx(smoothed(noise()[HEAD:], 16))
