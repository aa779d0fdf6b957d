"""The noise of readings, whatever slow signal and few jumps they have besides."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.signals.neighbour_noise import (
    counting_noise,
    neighbour_noise,
    of_differences,
    running_median,
)
from motorid.estimate.signals.voltage_jumps import scatter

NOISE = 0.3 * np.random.default_rng(5).standard_normal(20_000)
PLACE = np.arange(20_000.0)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_white_noise_is_found_by_differences_of_any_order(order: int) -> None:
    assert neighbour_noise(NOISE, order) == pytest.approx(0.3, rel=0.03)
    jumps = 50.0 * (PLACE > 7_000) - 80.0 * (PLACE > 12_000)
    assert neighbour_noise(NOISE + jumps, order) == pytest.approx(0.3, rel=0.03)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_polynomial_of_a_lower_order_is_no_noise(order: int) -> None:
    curve = np.polyval([2.0] * order, PLACE[:200] / 8.0)  # of that order less one
    assert neighbour_noise(curve, order) == pytest.approx(0.0, abs=1e-9)
    assert neighbour_noise(np.polyval([2.0] * (order + 1), PLACE[:200] / 8.0), order) > 1e-3


@pytest.mark.parametrize("share", [0.3, 0.5, 1.0, 3.0])
def test_of_readings_in_coarse_steps_the_noise_is_that_of_rounding_too(share: float) -> None:
    """The median of their differences is a whole number of steps, of which none is none at all."""
    step = 0.3 / share
    read = step * np.round((NOISE + 60.0 * np.sin(PLACE / 2000.0)) / step)
    whole = np.hypot(0.3, step / np.sqrt(12.0))
    assert of_differences(np.diff(read, 2), 2, step) == pytest.approx(whole, rel=0.04)
    assert neighbour_noise(read) == pytest.approx(whole if share > 0.4 else 0.0, rel=0.04)
    assert scatter(read) == pytest.approx(whole, rel=0.06)


def test_readings_that_mostly_agree_have_no_noise() -> None:
    held = np.repeat([0.0, 6.0, -4.0, 5.0], 20)
    assert neighbour_noise(held) == 0.0
    assert scatter(np.tile(held, 10)) == 0.0
    blocks = np.stack([np.diff(held, 2), np.diff(NOISE[: len(held)], 2)])
    assert of_differences(blocks, 2) == pytest.approx([0.0, neighbour_noise(NOISE[: len(held)])])


def test_too_few_readings_tell_none() -> None:
    assert neighbour_noise(np.array([1.0, 2.0])) == 0.0
    assert neighbour_noise(np.array([])) == 0.0


def test_a_running_median_leaves_what_stands_alone() -> None:
    values = np.array([1.0, 2.0, 90.0, 4.0, 5.0, 6.0, 7.0])
    assert running_median(values, 1).tolist() == [1.0, 2.0, 4.0, 5.0, 5.0, 6.0, 7.0]
    assert running_median(values, 2).tolist() == [1.0, 2.0, 4.0, 5.0, 6.0, 6.0, 7.0]


def test_a_rare_count_scatters_by_half_of_it() -> None:
    counts = 3.0 * (np.random.default_rng(6).random(2000) < 0.3)
    assert neighbour_noise(counts, 1) < 1e-9  # most neighbours agree
    assert counting_noise(counts) == pytest.approx(1.5)
    held = np.repeat(np.sin(np.arange(200.0)), 10)  # has many levels
    assert counting_noise(held) == 0.0
    assert counting_noise(NOISE) == counting_noise(np.zeros(100)) == 0.0
