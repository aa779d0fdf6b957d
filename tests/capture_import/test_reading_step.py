"""The step of which all readings of a column are multiples, and columns that have none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from motorid.capture.reading_step import reading_step


@pytest.mark.parametrize(
    ("levels", "each", "step"),
    [
        ([0.0, 0.5], 4, 0.5),
        ([3.0], 9, 0.0),
        ([-7.0, -5.0, -1.0, 5.0], 4, 2.0),
        ([5.0, 6.0, 7.2], 4, 1.1),  # the middle is .09 steps off the grid of both ends
        ([5.0, 6.0, 7.24], 4, 0.0),  # .11
        ([5.0, 6.0, 8.2, 9.2], 4, 1.05),
        ([1e9, 1e9 + 0.5], 4, 0.0),  # no more than a double's own grain
        ([-1e9, 2.0 - 1e9], 4, 2.0),
    ],
)
def test_the_step_that_all_readings_share(levels: list[float], each: int, step: float) -> None:
    assert reading_step(np.tile(levels, each)) == pytest.approx(step, rel=1e-9)


def test_a_difference_of_angles_has_the_step_of_its_counts() -> None:
    angle = 2 * np.pi / 2048 * np.cumsum(np.tile([0.0, 3.0, 4.0, 7.0], 400))
    speed = np.diff(angle) / 2e-4
    assert len(np.unique(speed)) > 4  # by the last digits
    assert reading_step(speed) == pytest.approx(2 * np.pi / 2048 / 2e-4, rel=1e-9)


def test_an_angle_of_counts_that_never_come_back_has_their_step() -> None:
    rng = np.random.default_rng(0)
    counts = np.cumsum(rng.integers(1, 9, 3000))
    angle = 2 * np.pi / 2048 * counts
    assert reading_step(angle) == pytest.approx(2 * np.pi / 2048, rel=1e-9)
    noisy = angle + 1e-5 * rng.standard_normal(len(angle))
    assert reading_step(noisy) == 0.0


def test_many_bits_have_their_step_as_far_as_a_file_writes_them() -> None:
    rng = np.random.default_rng(1)
    step = 2.6 * 47.5 / 2**16
    read = np.round(60.0 * rng.standard_normal(4000) / step) * step
    written = np.array([float(f"{x:.9g}") for x in read])
    assert reading_step(written) == pytest.approx(step, rel=1e-6)


def test_readings_of_few_repetitions_or_many_levels_look_continuous() -> None:
    assert reading_step(np.tile([0.0, 1.0], 4)[:7]) == 0.0  # three and a half of each level
    assert reading_step(np.tile(np.arange(4096.0), 4)) == 1.0
    rough = np.arange(4097.0) + 0.02 * (np.arange(4097) % 2)
    assert reading_step(np.tile(rough[:4096], 4)) > 0.0
    assert reading_step(np.tile(rough, 4)) == 0.0


@pytest.mark.slow
@given(
    st.lists(st.integers(-(2**15), 2**15), min_size=32, max_size=400),
    st.floats(1e-9, 1e6),
    st.floats(-1e3, 1e3),
)
def test_multiples_of_a_step_have_it_or_a_multiple_of_it(
    counts: list[int], step: float, zero: float
) -> None:
    found = reading_step(step * (np.array(counts) + round(zero)))
    if found:
        assert found / step == pytest.approx(round(found / step), rel=1e-3)


@pytest.mark.parametrize(
    "extremes", [[1.7e308, -1.7e308], [5e-324, 1e-323, 0.0], [0.0, 5e-324, 1e-300], [1e300, 1e-300]]
)
def test_extremes_have_an_answer(extremes: list[float]) -> None:
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        assert reading_step(np.tile(extremes, 8)) >= 0.0


@pytest.mark.slow
@given(arrays(np.float64, st.integers(0, 64), elements=st.floats(allow_nan=False)))
def test_any_finite_readings_have_an_answer(values: NDArray[np.float64]) -> None:
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        assert reading_step(values) >= 0.0
