"""Kernels of smoothing against scipy's filters; what they hide of noise against drawn noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d, uniform_filter1d
from scipy.signal import butter, filtfilt, lfilter, savgol_filter

from motorid.estimate.effects.reading.smoothing_kernels import (
    FARTHEST,
    SMOOTHINGS,
    Smoothing,
    both_ways,
    gaussian,
    hidden,
    moving_mean,
    of_the_last,
    recursive,
    savitzky_golay,
    smoothed,
)

SERIES = np.concatenate([np.zeros(60), np.ones(80), 0.3 * np.ones(60)])  # as steps of a current


@pytest.mark.parametrize("m", [2, 5, 20])
def test_whole_half_widths_are_scipys(m: int) -> None:
    mean = uniform_filter1d(SERIES, 2 * m + 1, mode="nearest")
    assert smoothed(SERIES, moving_mean(m)) == pytest.approx(mean, abs=1e-12)
    for order in (2, 3):  # the same in the middle of a window
        ours = smoothed(SERIES, savitzky_golay(m))
        scipys = savgol_filter(SERIES, 2 * m + 1, order, mode="nearest")
        assert ours == pytest.approx(scipys, abs=1e-12)


@pytest.mark.parametrize("sd", [0.7, 3.0, 11.0])
def test_a_gaussian_is_scipys(sd: float) -> None:
    scipys = gaussian_filter1d(SERIES, sd, mode="nearest")
    assert smoothed(SERIES, gaussian(sd)) == pytest.approx(scipys, abs=1e-4)  # it ends elsewhere


@pytest.mark.parametrize(
    "share", [0.02, 0.05]
)  # of the Nyquist frequency, where both filters agree
def test_a_low_pass_both_ways_is_scipys(share: float) -> None:
    scipys = filtfilt(*butter(2, share), SERIES, padlen=50)
    ours = smoothed(SERIES, both_ways(np.sqrt(2.0) / (np.pi * share)))
    assert ours == pytest.approx(scipys, abs=0.01)


@pytest.mark.parametrize("counts", [0.8, 0.5, 0.1])
def test_a_recursive_average_is_scipys(counts: float) -> None:
    scipys = lfilter([counts], [1.0, counts - 1.0], SERIES)
    ours = smoothed(SERIES, recursive(1.0 / counts - 1.0))
    assert ours == pytest.approx(scipys, abs=1e-4)  # it ends somewhere


@pytest.mark.parametrize("count", [2, 3, 8])
def test_a_mean_of_the_last_readings_is_scipys(count: int) -> None:
    scipys = uniform_filter1d(SERIES, count, origin=(count - 1) // 2, mode="nearest")
    assert smoothed(SERIES, of_the_last(count - 1.0)) == pytest.approx(scipys, abs=1e-12)


@pytest.mark.parametrize("way", SMOOTHINGS)
def test_kernels_have_a_sum_of_one_and_are_even_or_behind(way: Smoothing) -> None:
    for size in (0.0, 0.4, 1.0, 2.6, 30.0, 1e4):
        h = way.kernel(size)
        assert len(h) <= 2 * FARTHEST + 1
        assert h.sum() == pytest.approx(1.0)
        if way.behind:
            assert not h[: len(h) // 2].any()
        else:
            assert h == pytest.approx(h[::-1])


@pytest.mark.parametrize("way", SMOOTHINGS)
def test_a_smoothing_says_how_wide_it_is(way: Smoothing) -> None:
    assert way.wide(1.0) == {
        "a recursive average": "a new reading counts 0.5", "a mean of the last readings": "of 2",
    }.get(way.how, "3 readings wide")  # fmt: skip
    assert max(way.sizes) <= way.most


@pytest.mark.parametrize("kernel", [moving_mean, of_the_last])
def test_between_two_sizes_is_a_mixture(kernel) -> None:  # type: ignore[no-untyped-def]
    mixed = smoothed(SERIES, kernel(3.25))
    parts = 0.75 * smoothed(SERIES, kernel(3)) + 0.25 * smoothed(SERIES, kernel(4))
    assert mixed == pytest.approx(parts)


@pytest.mark.parametrize("way", SMOOTHINGS)
@pytest.mark.parametrize("order", [1, 2])
def test_what_neighbours_do_not_show_of_smoothed_noise(way: Smoothing, order: int) -> None:
    noise = smoothed(np.random.default_rng(3).standard_normal(200_000), way.kernel(4.0))
    shown = np.mean(np.diff(noise, order) ** 2) / {1: 2.0, 2: 6.0}[order]
    ratio = hidden(way.kernel(4.0), order)
    assert ratio == pytest.approx(noise.var() / shown, rel=0.05)
    assert ratio > 1.0
