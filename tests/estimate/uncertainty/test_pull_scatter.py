"""The scatter of an effect's pull: of white, of few large and of slow residuals."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import lfilter

from motorid.estimate.uncertainty.pull_scatter import STRETCHES, _stretches, pull_scatter

READINGS = 4000
CHANGE = np.linspace(0.0, 1.0, READINGS) ** 2


def drawn(correlation: float, count: int) -> NDArray[np.float64]:
    """(count, READINGS) of deviation 1, each reading like the one before by ``correlation``."""
    white = np.random.default_rng(1).standard_normal((count, 2 * READINGS))
    slow = lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white)
    return np.asarray(slow[:, READINGS:])


@pytest.mark.slow
@pytest.mark.parametrize("correlation", [0.0, 0.9, 0.98])
def test_it_is_the_variance_that_many_draws_show(correlation: float) -> None:
    residuals = drawn(correlation, 400)
    true = float(np.var(residuals @ CHANGE) / (CHANGE @ CHANGE))
    found = [pull_scatter([CHANGE], [one]) for one in residuals]
    assert np.mean(found) == pytest.approx(true, rel=0.35)


def test_a_true_effect_leaves_nothing_to_it() -> None:
    noise = drawn(0.0, 1)[0]
    alone, beside = (pull_scatter([CHANGE], [noise + size * CHANGE]) for size in (0.0, 100.0))
    assert beside == pytest.approx(alone)


@pytest.mark.parametrize(("left", "scatter"), [(1.0, 1.0), (5.0, 25.0), (0.2, 1.0)])
def test_few_readings_that_are_left_more_say_less_of_an_effect(left: float, scatter: float) -> None:
    """Ten of a thousand show it, after jumps of a voltage that nobody knows between readings."""
    residual, change = np.tile([1.0, -1.0], 500), np.zeros(1000)
    change[:10], residual[:10] = 1.0, left * residual[:10]
    assert pull_scatter([change], [residual]) == pytest.approx(scatter, rel=0.1)


def test_records_that_agree_say_more_than_one() -> None:
    """A part that both have is taken for the effect; what they differ by is scatter."""
    step = np.where(np.arange(READINGS) < READINGS // 2, 1.0, -1.0)
    same = pull_scatter([CHANGE, CHANGE], [3.0 * CHANGE, 3.0 * CHANGE])
    other = pull_scatter([CHANGE, CHANGE], [step * CHANGE, -step * CHANGE])
    assert same == 1.0
    assert other > STRETCHES


def test_what_no_reading_shows_does_not_scatter() -> None:
    assert pull_scatter([], []) == 1.0
    assert pull_scatter([np.zeros(5)], [np.ones(5)]) == 1.0


def test_stretches_tell_as_much_of_an_effect_each() -> None:
    """Eight of them: of a change that is even, and of one that is thrice as large later on."""
    assert _stretches(np.ones(80)).tolist() == [10 * k for k in range(8)]
    change = np.where(np.arange(100) < 90, 1.0, 3.0)  # 90 and then 90 again
    begins = _stretches(change)
    sums = np.add.reduceat(change**2, begins)
    assert len(begins) == 8
    assert sums == pytest.approx(np.full(8, 22.5), abs=9.0)
    assert _stretches(np.r_[np.zeros(9), 1.0]).tolist() == [0, 9]  # one reading tells all


def test_a_scatter_is_of_sums_over_stretches_or_of_single_readings() -> None:
    """Eight stretches of ten readings, each off alike: of their sums 8/7, of each alone 1."""
    left = np.repeat([1.0, -1.0] * 4, 10)
    assert pull_scatter([np.ones(80)], [left]) == pytest.approx(8 * 100.0 * 8 / 7 / 80.0)
    turns = np.tile([3.0, -3.0], 40)
    assert pull_scatter([np.ones(80)], [turns]) == pytest.approx(9.0)
    twice = pull_scatter([np.ones(80)] * 2, [left, turns])
    assert twice == pytest.approx(max(8 * 100.0 * 8 / 7 / 160.0, (80.0 + 720.0) / 160.0))
