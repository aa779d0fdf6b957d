"""A low-pass of second order against scipy's own simulation of it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from motorid.capture.model import BUTTERWORTH, CURRENT, Channel
from motorid.estimate.signals.second_order_filter import SecondOrder

PERIOD_S, TIME_S = 1e-4, 8e-4


def channel(damping: float) -> Channel:
    return Channel(
        CURRENT, "A", np.zeros(1), filter_s=TIME_S, filter_order=2, filter_damping=damping,
        delay_s=5e-3,
    )  # fmt: skip


@pytest.mark.parametrize("damping", [BUTTERWORTH, 1.0, 2.0])
def test_it_does_what_the_transfer_function_says(damping: float) -> None:
    time = PERIOD_S * np.arange(400)
    series = np.interp(time, [0.0, 5e-3, 6e-3, 2e-2, 2.1e-2, 4e-2], [0.0, 0.0, 1.0, 1.2, -0.4, 0.1])
    system = ([1.0], [TIME_S**2, 2.0 * damping * TIME_S, 1.0])
    _, expected, _ = signal.lsim(system, series, time)
    smoothed = SecondOrder.of(channel(damping), PERIOD_S)(series)
    assert np.abs(smoothed - expected).max() < 1e-9


@pytest.mark.parametrize("damping", [BUTTERWORTH, 1.0])
def test_a_steady_change_comes_later_by_its_delay(damping: float) -> None:
    one = channel(damping)
    ramp = np.arange(2000.0)
    smoothed = SecondOrder.of(one, PERIOD_S)(ramp)
    late = (ramp - smoothed)[-1] * PERIOD_S
    assert late == pytest.approx(one.filter_delay_s, rel=1e-9)


def test_it_has_stood_at_its_first_value() -> None:
    assert SecondOrder.of(channel(1.0), PERIOD_S)(np.full(50, 3.0)) == pytest.approx(3.0)
