"""To which step stamps were rounded, and when they are a grid as they stand, by a few stamps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.stamp_grid import grid_of, regular, written_twice
from motorid.capture.stamp_period import laid
from motorid.capture.stamp_resolution import resolutions

NAN = float("nan")
EPS = 2.0**-52


def steps_of(stamps: list[float], steps: list[float] | None = None) -> list[Any]:
    array = np.array(stamps)
    return list(resolutions(array, np.diff(array) if steps is None else np.array(steps)))


@pytest.mark.parametrize(
    ("stamps", "step"),
    [
        ([0.0, 0.25, 0.5, 0.75], 0.25),  # hundredths, of which all are 25 apart
        ([0.01, 0.02, 0.05, 0.06], 0.01),
        ([100.0, 200.0, 500.0], 100.0),
        ([0.0, 4.0, 10.0, 12.0], 2.0),
        ([0.0, 1.0, 2.5, 3.5], 0.5),
        ([-3.0, -1.5, 1.5], 1.5),
        ([3.0, 4.5, 9.0], 1.5),
    ],
)
def test_the_step_of_the_digits(stamps: list[float], step: float) -> None:
    written = steps_of(stamps)[0]
    assert written == pytest.approx(np.full(len(stamps), step))


def test_significant_digits_are_coarser_the_larger_a_stamp_is() -> None:
    written = steps_of([9.97, 9.98, 9.99, 10.1, 10.3, 99.8, 101.0, 103.0, 104.0])[0]
    assert written == pytest.approx([0.01] * 3 + [0.1] * 3 + [1.0] * 3)


def test_arithmetic_of_stamps_leaves_its_noise() -> None:
    written = steps_of([0.0, 1.0, 3.0, 4.0])[0]
    assert written - 1.0 == pytest.approx(np.full(4, 2 * 4 * EPS * 4.0), rel=0.1, abs=0.0)


def test_a_number_of_single_precision_is_rounded_to_its_23rd_binary_digit() -> None:
    stamps = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    written, single = steps_of(stamps)[:2]
    binary = [0.0, 2.0**-23, 2.0**-22, 2.0**-22, 2.0**-21, 2.0**-21]
    assert (single - written)[1:] == pytest.approx(binary[1:], rel=1e-6)


@pytest.mark.parametrize(
    ("steps", "timer"),
    [
        ([10.0] * 3 + [16.0] * 3, 6.0),
        ([10.0] * 9 + [16.0] * 2, None),  # seen twice: late
        ([10.0] * 2 + [16.0] * 9, None),
        ([10.0] * 3 + [13.0] * 3, None),  # no more than a few of the digits' step of 1
        ([10.0] * 3 + [16.0] * 3 + [13.0], None),  # between the two
        ([10.0, 10.9, 10.0, 16.0, 15.1, 16.0], 6.0),  # within a step of the digits
    ],
)
def test_two_steps_that_alternate_are_a_timer_s(steps: list[float], timer: float | None) -> None:
    found = steps_of([0.0, 1.0, 3.0, 4.0], steps)
    assert len(found) == (2 if timer is None else 3)
    if timer is not None:
        assert found[2] == pytest.approx(np.full(4, 1.0 + timer))


@pytest.mark.parametrize(
    ("steps", "grid"),
    [
        ([5, 5, 10, 15], True),
        ([5, 5, 12], False),
        ([0, 5, 5], False),
        ([-5, 5, 5], False),
        ([5] * 92 + [10] * 8, False),  # eight doubles of a hundred: rounded
        ([5] * 93 + [10] * 7, True),  # seven are losses
        ([5] * 191 + [10] * 9, True),  # under one in twenty
        ([5] * 190 + [10] * 10, False),
        ([5] * 90 + [10] * 9 + [15], True),  # three at once are losses
    ],
)
def test_steps_that_are_a_grid_as_they_stand(steps: list[int], grid: bool) -> None:
    assert regular(np.array(steps)) is grid


def test_rows_that_repeat_a_stamp_and_all_readings_are_written_twice() -> None:
    stamps = np.array([0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    twice, drifting = np.repeat([1.0, 2.0, 3.0, 4.0], 2), np.arange(8.0)
    partly = np.array([1.0, 1.0, 2.0, 2.0, 3.0, 3.5, 4.0, 4.5])
    assert written_twice(stamps, [twice])
    assert written_twice(stamps, [twice, np.where(np.arange(8) % 2, NAN, drifting)])
    assert not written_twice(stamps, [twice, drifting])
    assert not written_twice(stamps, [partly])  # half of them
    assert written_twice(stamps, [np.where(stamps == 2.0, 3.0, partly)])  # three of four
    assert not written_twice(np.arange(8.0), [np.ones(8)])  # none repeats


# -- a period between bounds
def test_the_period_lies_in_the_middle_of_those_that_rounding_allows() -> None:
    stamps, count = np.array([10.0, 11.0, 13.0]), np.array([0, 1, 3])
    grid = laid(stamps, count, np.full(3, 0.1), [])
    assert grid is not None
    # three periods are 3 within the two halves of a step of .1
    assert grid.period == pytest.approx(1.0)
    assert grid.uncertainty == pytest.approx(2 * 0.1 / 3 / np.sqrt(12.0))
    assert (grid.start, grid.resolution) == (pytest.approx(0.0), pytest.approx(0.1))
    assert grid.coarse == pytest.approx(0.1)
    assert grid.places.tolist() == [0.0, 1.0, 3.0]


def test_stamps_that_were_cut_off_begin_half_a_step_later() -> None:
    period, count = 1.0, np.array([0, 1, 2, 3, 4, 5, 6, 7])
    stamps = np.floor((count * period + 0.25) / 0.5) * 0.5 + 20.0  # each a quarter early
    late = stamps + np.where(count == 3, 0.5, 0.0)
    grid = laid(late, count, np.full(8, 0.5), [])
    assert grid is not None
    # one is half a step above the others: only a start halfway is within half a step of all
    assert grid.start == pytest.approx(0.25)
    assert grid.period == pytest.approx(1.0)
    assert grid.uncertainty == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("size", [0.24, 0.26])
def test_a_stamp_beyond_its_rounding_has_no_grid(size: float) -> None:
    count = np.arange(9)
    stamps = count + np.where(count == 4, size, 0.0)
    grid = laid(stamps, count, np.full(9, 0.25), [])
    assert (grid is not None) is (size < 0.25)


def test_parts_begin_where_they_like_with_one_period() -> None:
    count = np.array([0, 1, 2, 3, 9, 10, 11, 12])
    stamps = np.array([0.0, 2.0, 4.0, 6.0, 18.6, 20.6, 22.6, 24.6]) + 50.0
    assert laid(stamps, count, np.full(8, 0.01), []) is None
    grid = laid(stamps, count, np.full(8, 0.01), [4])
    assert grid is not None
    assert grid.period == pytest.approx(2.0)
    assert grid.places == pytest.approx([0.0, 1.0, 2.0, 3.0, 9.3, 10.3, 11.3, 12.3])
    # of either part three periods are 6 within two halves of .01
    assert grid.uncertainty == pytest.approx(2 * 0.01 / 3 / (np.sqrt(12.0) * 2.0))


@pytest.mark.parametrize("stamps", [np.zeros(20), np.arange(15.0), -np.arange(20.0)])
def test_too_few_stamps_or_ones_that_stand_have_no_grid(stamps: Any) -> None:
    assert grid_of(stamps, np.arange(float(len(stamps)))) is None


def test_sixteen_stamps_have_one() -> None:
    grid = grid_of(np.arange(16.0), np.arange(16.0))
    assert grid is not None
    assert grid.period == pytest.approx(1.0)
