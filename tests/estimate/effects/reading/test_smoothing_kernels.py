"""Kernels of smoothing against scipy's filters; what they hide of noise against drawn noise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d, uniform_filter1d
from scipy.signal import butter, filtfilt, savgol_filter

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.smoothing_around import (
    FARTHEST,
    KERNELS,
    SMOOTHING_AROUND,
    both_ways,
    gaussian,
    hidden_noise,
    moving_mean,
    savitzky_golay,
    smoothed,
)
from motorid.estimate.solver.problem import Unknown

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


@pytest.mark.parametrize("kernel", KERNELS.values())
def test_kernels_are_even_and_of_sum_one(kernel) -> None:  # type: ignore[no-untyped-def]
    for size in (0.0, 0.4, 1.0, 2.6, 30.0, 1e4):
        h = kernel(size)
        assert len(h) <= 2 * FARTHEST + 1
        assert h.sum() == pytest.approx(1.0)
        assert h == pytest.approx(h[::-1])


def test_between_two_half_widths_is_a_mixture() -> None:
    mixed = smoothed(SERIES, moving_mean(3.25))
    parts = 0.75 * smoothed(SERIES, moving_mean(3)) + 0.25 * smoothed(SERIES, moving_mean(4))
    assert mixed == pytest.approx(parts)


@pytest.mark.parametrize("how", KERNELS)
@pytest.mark.parametrize("order", [1, 2])
def test_what_neighbours_do_not_show_of_smoothed_noise(how: str, order: int) -> None:
    size = 4.0
    noise = smoothed(np.random.default_rng(3).standard_normal(200_000), KERNELS[how](size))
    shown = np.mean(np.diff(noise, order) ** 2) / {1: 2.0, 2: 6.0}[order]
    one = Instance(SMOOTHING_AROUND[CURRENT][how])
    unknown = Unknown(one.name, size)
    ratio = hidden_noise([one], [unknown], CURRENT, order)
    assert ratio == pytest.approx(noise.var() / shown, rel=0.05)
    assert ratio > 1.0
    assert hidden_noise([one], [unknown], SPEED, order) == 1.0
    assert hidden_noise([], [], CURRENT, order) == 1.0
