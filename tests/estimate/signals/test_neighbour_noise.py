"""The noise of readings, whatever slow signal and few jumps they have besides."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.signals.neighbour_noise import neighbour_noise

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


def test_too_few_readings_tell_none() -> None:
    assert neighbour_noise(np.array([1.0, 2.0])) == 0.0
    assert neighbour_noise(np.array([])) == 0.0
