"""The grid of most stamps, which a few miss; a grid in parts; the clock that a grid gives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture.stamp_grid import _by_rows, _by_steps, _core, _grid, _of_most, grid_of
from motorid.capture.stamp_period import Grid, laid
from motorid.capture.stamp_resolution import _decimal_step, _of_timer, _shared
from motorid.capture.stamps import _nanoseconds, _on_grid, _repeats

PERIOD = 10.0


def off_by(count: int, off: dict[int, float]) -> Any:
    """Stamps of a period of 10 from 50 on, some of which are late by so much."""
    stamps = 50.0 + PERIOD * np.arange(count)
    for place, late in off.items():
        stamps[place] += late
    return stamps


def most(count: int, off: dict[int, float], resolution: float = 0.1) -> Grid | None:
    stamps = off_by(count, off)
    return _of_most(stamps, np.full(count, resolution))


@pytest.mark.parametrize("late", [3.7, -3.7, 0.15])  # .15 is within two periods' usual scatter
def test_late_stamps_keep_their_moments_on_the_grid_of_the_others(late: float) -> None:
    grid = most(40, {12: late, 20: late, 30: late})
    assert grid is not None
    places = np.arange(40.0)
    places[[12, 20, 30]] += late / PERIOD
    assert grid.places == pytest.approx(places, abs=1e-9)
    assert np.array_equal(np.delete(grid.places, [12, 20, 30]), np.delete(places, [12, 20, 30]))
    assert (grid.period, grid.resolution) == (pytest.approx(PERIOD), pytest.approx(0.1))
    assert grid.start == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("first", [2.0, -2.0])
def test_time_begins_with_the_first_stamp_be_it_late(first: float) -> None:
    grid = most(40, {0: first, 12: 3.7})
    assert grid is not None
    assert np.array_equal(grid.places, np.arange(40.0) + np.where(np.arange(40) == 12, 0.37, 0.0))


def test_stamps_that_were_cut_off_lie_on_the_grid_all_the_same() -> None:
    moments = 10.03 * np.arange(60.0) + 0.02
    moments[25] += 4.0
    grid = _of_most(np.floor(moments / 0.1) * 0.1, np.full(60, 0.1))
    assert grid is not None
    others = np.arange(60) != 25
    assert np.array_equal(grid.places[others], np.arange(60.0)[others])
    assert grid.places[25] == pytest.approx(25 + 4.0 / 10.03, abs=0.1 / 10.03)
    assert grid.period == pytest.approx(10.03, abs=0.1 / 59)


@pytest.mark.parametrize("late", [3.7, 0.15])
def test_nine_stamps_in_ten_make_a_grid(late: float) -> None:
    """Each of .15 is between steps that are still one period, and misses the grid alone."""
    some = dict.fromkeys((5, 12, 20, 30, 35), late)
    assert most(40, some) is None
    some.pop(5)
    assert most(40, some) is not None


@pytest.mark.parametrize(("count", "found"), [(18, True), (17, True), (16, False)])
def test_sixteen_stamps_of_the_line_make_a_grid(count: int, found: bool) -> None:
    assert (most(count, {8: 3.7}) is not None) is found


@pytest.mark.parametrize(("resolution", "found"), [(0.9, True), (1.1, False)])
def test_stamps_of_a_tenth_of_a_period_say_which_were_late(resolution: float, found: bool) -> None:
    assert (most(40, {12: 3.7}, resolution) is not None) is found


@pytest.mark.parametrize(
    ("resolution", "off", "on"),  # five quarters of half a step of the digits, or of 2e-5 periods
    [(0.1, 0.06, True), (0.1, 0.065, False), (1e-6, 1.1e-4, True), (1e-6, 1.4e-4, False)],
)
def test_a_stamp_a_little_beyond_its_rounding_is_on_the_grid_of_others(
    resolution: float, off: float, on: bool
) -> None:
    grid = most(40, {20: off}, resolution)
    assert grid is not None
    assert bool(grid.places[20] == 20.0) is on
    assert grid.places[20] == pytest.approx(20.0 + (0.0 if on else off / PERIOD), abs=1e-9)


@pytest.mark.parametrize(("late", "found"), [(9.98, True), (9.995, False)])
def test_samples_lie_a_thousandth_of_a_period_apart(late: float, found: bool) -> None:
    assert (most(40, {12: late}, 1e-4) is not None) is found


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("off", "found"), [(0.9e-4, True), (1.6e-4, False)])
def test_stamps_so_close_to_a_grid_are_on_it_in_any_unit(
    off: float, found: bool, scale: float
) -> None:
    """A hundred thousandth of a period is no lateness, however finely the stamps are written."""
    stamps = off_by(40, {12: 3.7}) + off * (np.arange(40) % 3 - 1.0)
    grid = _of_most(scale * stamps, np.full(40, scale * 1e-9))
    assert (grid is not None) is found
    if grid is not None:
        assert np.flatnonzero(grid.places != np.arange(40.0)).tolist() == [12]
        assert grid.period == pytest.approx(scale * PERIOD, rel=1e-5)


def test_two_stamps_of_one_place_have_no_grid() -> None:
    stamps = np.insert(off_by(40, {}), 20, 50.0 + 20 * PERIOD)
    assert _of_most(stamps, np.full(41, 0.1)) is None


# -- the stamps that lay the grid
def test_the_core_is_what_lies_within_the_rounding_of_the_line_of_most() -> None:
    stamps = off_by(40, {6: 3.0, 12: 0.06, 20: 0.04, 21: -0.04, 30: -0.06, 35: 3.0})
    core, count = _core(stamps, np.full(40, 0.1), 9.9)
    assert np.flatnonzero(~core).tolist() == [6, 12, 30, 35]
    assert count.tolist() == list(range(40))


def test_lost_samples_leave_their_places_empty() -> None:
    stamps = np.delete(off_by(40, {}), [7, 8, 20])
    core, count = _core(stamps, np.full(37, 0.1), PERIOD)
    assert core.all()
    assert count.tolist() == [n for n in range(40) if n not in (7, 8, 20)]
    assert _by_steps(stamps) is not None
    assert np.array_equal(_by_steps(stamps), count)


def test_too_few_stamps_have_no_core() -> None:
    core, _ = _core(off_by(15, {}), np.full(15, 0.1), PERIOD)
    assert not core.any()
    assert _core(off_by(16, {}), np.full(16, 0.1), PERIOD)[0].all()


# -- places
def test_rows_count_samples_from_the_first() -> None:
    assert _by_rows(np.array([3.0, 4.0, 7.0])).tolist() == [0, 1, 4]


def test_steps_count_no_samples_where_stamps_stand() -> None:
    assert _by_steps(np.array([0.0, 1.0, 1.0, 2.0])) is None
    # 3 and 2 of a timer alternate: each is one sample
    steps = np.r_[[3.0, 2.0] * 10, 7.5, [3.0, 2.0] * 5]
    count = _by_steps(np.r_[0.0, np.cumsum(steps)])
    assert count is not None
    assert np.diff(count).tolist() == [1] * 20 + [3] + [1] * 10


PAUSED = np.r_[0:10, 1000:1010].astype(float)


def test_places_that_a_pause_made_unsure_are_counted_again() -> None:
    """Three too many were counted over the pause, by a period known too little."""
    wrong = PAUSED.astype(np.int64) + np.where(PAUSED > 100, 3, 0)
    grid = _grid(40.0 + 2.0 * PAUSED, wrong, np.full(20, 0.01))
    assert grid is not None
    assert np.array_equal(grid.places, PAUSED)
    assert grid.period == pytest.approx(2.0)
    assert grid.uncertainty == pytest.approx(2 * 0.01 / 1009 / 2.0 / np.sqrt(12.0), rel=1e-3)


def test_a_new_phase_after_a_pause_is_kept() -> None:
    count = np.r_[0:10, 30:40]
    moments = count + np.where(count > 20, 0.3, 0.0)
    grid = _grid(40.0 + 2.0 * moments, count, np.full(20, 0.01))
    assert grid is not None
    assert grid.places == pytest.approx(moments)
    assert grid.period == pytest.approx(2.0)


@pytest.mark.parametrize(("lost", "found"), [(2, True), (1, False)])
def test_a_pause_is_of_three_periods(lost: int, found: bool) -> None:
    moments = np.r_[0:20, 20 + lost : 40 + lost].astype(float)
    count = moments.astype(np.int64)
    moments[20:] += 0.3
    grid = _grid(2.0 * moments, count, np.full(40, 0.01))
    assert (grid is not None) is found


def test_places_that_do_not_rise_have_no_grid() -> None:
    count = np.array([0, 1, 1, 2])
    assert _grid(np.array([0.0, 1.0, 1.0, 2.0]), count, np.full(4, 0.01)) is None


def test_stamps_of_several_samples_each_are_counted_by_rows_alone() -> None:
    rows = np.arange(90.0)
    stamps = np.floor((rows + 0.3) / 2.7)
    grid = grid_of(stamps, rows)
    assert grid is not None
    assert np.array_equal(grid.places, rows)
    assert grid.period == pytest.approx(1 / 2.7, rel=0.02)


# -- periods
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_grid_is_the_same_in_any_unit(scale: float) -> None:
    count = np.array([0, 1, 2, 3, 9, 10, 11, 12])
    stamps = np.array([0.0, 2.0, 4.0, 6.1, 18.6, 20.6, 22.6, 24.7])
    grid = laid(scale * stamps, count, scale * np.full(8, 0.2), [4])
    assert grid is not None
    # over three periods of either part 6.1 is within two halves of .2: 5.9 to 6.3
    assert grid.period == pytest.approx(scale * 6.1 / 3)
    assert grid.uncertainty == pytest.approx(0.4 / 6.1 / np.sqrt(12.0), rel=1e-6)
    assert grid.resolution == pytest.approx(0.2 * scale)
    assert np.diff(grid.places)[[0, 1, 2, 4, 5, 6]] == pytest.approx(np.ones(6))


@pytest.mark.parametrize(("resolution", "found"), [(0.5, True), (4.0, False)])
def test_a_period_that_could_be_0_is_none(resolution: float, found: bool) -> None:
    grid = laid(np.array([0.0, 1.0]), np.array([0, 1]), np.full(2, resolution), [])
    assert (grid is not None) is found
    if grid is not None:
        assert grid.period == pytest.approx(1.0)
        assert grid.uncertainty == pytest.approx(2 * 0.5 / np.sqrt(12.0))


def test_stamps_that_run_backwards_have_no_period() -> None:
    assert laid(np.array([0.0, -1.0, -2.0]), np.arange(3), np.full(3, 0.1), []) is None


# -- rounding
def test_differences_count_their_step_however_large_the_stamps_are() -> None:
    assert _shared(np.array([4e15, 4e15 + 6, 4e15 + 15]), 1.0) == 3.0
    assert _shared(np.array([7.0, 7.5, 9.0]), 0.25) == 0.5
    assert _shared(np.array([0.0, 2e14, 4e14]), 1.0) == 2e14
    assert _shared(np.array([0.0, 2e15, 4e15]), 1.0) == 1.0  # no double is exact to so much


@pytest.mark.parametrize(
    ("stamps", "decade", "step"),
    [
        ([0.135, 0.2], -1, 1e-3),
        ([1350.0, 2000.0], 3, 10.0),
        ([3.0], 0, 1.0),
        ([0.1353352832366127], -1, 1e-16),  # all digits that a double has
        ([135335.2832366127], 5, 1e-10),
        ([*[0.5] * 300, 0.25], -1, 0.01),
    ],
)
def test_the_power_of_ten_that_stamps_of_a_decade_share(
    stamps: list[float], decade: int, step: float
) -> None:
    assert _decimal_step(np.array(stamps), decade) == pytest.approx(step, rel=1e-9)


def test_a_timer_s_two_steps_are_apart_by_its_own() -> None:
    steps = np.array([10.0, 16.0] * 3)
    assert _of_timer(steps, 1.0) == 6.0
    assert _of_timer(steps, 1.4) == 6.0
    assert _of_timer(steps, 1.6) == 0.0  # less than four of the digits' steps


# -- clocks
def grid(period: float, resolution: float) -> Grid:
    return Grid(period, 0.0, np.array([0.0, 1.0, 2.5, 4.0]), resolution, 3e-5)


def test_a_clock_counts_whole_nanoseconds_of_a_period() -> None:
    notes: list[str] = []
    found = _on_grid(grid(12.5000000004, 0.01), 1e-3, notes)
    assert found.ticks.tolist() == [0, 12_500_000, 31_250_000, 50_000_000]
    assert found.hz == pytest.approx(12_500_000 / 12.5000000004e-3, rel=1e-14)
    assert found.uncertainty == 3e-5
    assert found.ahead is None
    assert found.grid is not None
    assert notes == []


def test_a_period_below_a_nanosecond_is_one_tick() -> None:
    found = _on_grid(grid(2e-10, 1e-13), 1.0, [])
    assert found.ticks.tolist() == [0, 1, 2, 4]
    assert found.hz == pytest.approx(5e9)


@pytest.mark.parametrize(("resolution", "said"), [(0.2, False), (0.3, True)])
def test_coarse_stamps_that_are_replaced_are_said(resolution: float, said: bool) -> None:
    notes: list[str] = []
    _on_grid(grid(12.5, resolution), 1e-3, notes)
    assert notes == (
        ["stamps are rounded to 0.0003 s: the uniform period 0.0125 s explains them all, "
         "and replaces them"] if said else []
    )  # fmt: skip


def test_stamps_are_nanoseconds_since_the_first() -> None:
    assert _nanoseconds(np.array([5.0, 5.25, 7.0]), 1e-3).tolist() == [0, 250_000, 2_000_000]


@pytest.mark.parametrize(
    ("ticks", "repeats"),
    [([1, 1, 2], True), ([1, 2, 3], False), ([1, 1, 0], False), ([1], False), ([4, 4], True)],
)
def test_stamps_repeat_where_none_steps_back(ticks: list[int], repeats: bool) -> None:
    assert _repeats(np.array(ticks)) is repeats
