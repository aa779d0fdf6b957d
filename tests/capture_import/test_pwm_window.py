"""A window over part of a PWM period, against the mean of the square wave itself."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.pwm_window import is_whole, largest_error

SWING_V = 12.0


def worst_mean(periods: float, duty: float) -> float:
    """V by which the mean of a square wave over a window misses its level, at the worst phase."""

    def charge(at: np.ndarray) -> np.ndarray:
        return np.floor(at) * duty + np.minimum(at % 1.0, duty)

    begin = np.linspace(0.0, 1.0, 2001)
    return float(np.abs((charge(begin + periods) - charge(begin)) / periods - duty).max() * SWING_V)


@pytest.mark.parametrize("periods", [0.1, 0.5, 0.9, 1.3, 2.5, 7.75])
@pytest.mark.parametrize("duty", [0.05, 0.3, 0.5, 0.8])
def test_the_error_is_that_of_the_worst_phase(periods: float, duty: float) -> None:
    assert largest_error(periods, duty, SWING_V) == pytest.approx(
        worst_mean(periods, duty), rel=1e-2
    )


@pytest.mark.parametrize("duty", [0.2, 0.5, 0.9])
def test_an_instant_sees_the_bridge_on_or_off(duty: float) -> None:
    assert largest_error(0.0, duty, SWING_V) == SWING_V * max(duty, 1.0 - duty)
    assert largest_error(0.0, duty, SWING_V, 2.0) == pytest.approx(
        SWING_V * duty * (1.0 - duty) / 4.0
    )
    assert largest_error(0.0, duty, SWING_V, 1e-6) == largest_error(0.0, duty, SWING_V)


def test_whole_periods_and_a_bridge_that_never_switches_show_the_level() -> None:
    assert is_whole(3.0005)
    assert is_whole(1.0)
    assert is_whole(0.9995)
    assert not is_whole(3.0015)
    assert not is_whole(0.0)
    for periods, duty in ((3.0, 0.4), (2.9995, 0.4), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)):
        assert largest_error(periods, duty, SWING_V) == 0.0
