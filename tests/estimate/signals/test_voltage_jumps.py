"""What a logged voltage must differ by to have jumped, whether rarely or every few rows."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import pytest

from motorid.estimate.signals.voltage_jumps import (
    CLEAR,
    SHARE,
    changes,
    count_of,
    jumps,
    least_jump,
    level_jumps,
    rounding,
    scatter,
)

COUNT, NOISE_V = 4000, 0.1
NOISE = NOISE_V * np.random.default_rng(11).standard_normal(COUNT)
PLACE = np.arange(COUNT)


def within(share: float) -> float:
    """Standard deviations within which that share of normal readings lies."""
    return NormalDist().inv_cdf(0.5 + share / 2.0)


@pytest.mark.parametrize("every", [2, 3])
def test_a_voltage_that_jumps_every_few_rows_has_its_jumps(every: int) -> None:
    """No stretch is calm: second differences take the jumps themselves for noise. Of neighbours a
    quarter of all are more of those of one level: half of them, or three eighths.
    """
    volts = np.where(PLACE // every % 2, 3.0, -3.0) + NOISE
    more = within(0.25 * every / (every - 1)) / within(0.25)
    assert least_jump(volts) == pytest.approx(CLEAR * NOISE_V * more, rel=0.05)
    assert jumps(volts).tolist() == [k for k in range(1, COUNT) if k % every == 0]


def test_of_levels_of_five_rows_second_differences_tell_the_noise() -> None:
    volts = np.where(PLACE // 5 % 2, 3.0, -3.0) + NOISE
    assert least_jump(volts) == CLEAR * scatter(volts) == pytest.approx(CLEAR * NOISE_V, rel=0.05)
    assert jumps(volts).tolist() == list(range(5, COUNT, 5))


@pytest.mark.parametrize("count", [400, 401, 402])
@pytest.mark.parametrize("begun", [0, 1])
def test_where_a_level_begins_and_ends_is_nothing_to_its_jumps(count: int, begun: int) -> None:
    """Of 401 rows, begun amid a pair, half of the differences are jumps: a median is of both."""
    place = PLACE[:count] + begun
    volts = np.where(place // 2 % 2, 3.0, -3.0) + NOISE[:count]
    assert CLEAR * scatter(volts) > 6.0
    assert CLEAR * NOISE_V < least_jump(volts) < 3.0 * CLEAR * NOISE_V
    assert jumps(volts).tolist() == [k for k in range(1, count) if (k + begun) % 2 == 0]


def test_neighbours_that_agree_are_as_noisy_as_a_count_of_their_converter() -> None:
    """A quarter of the differences is 0, where most readings of a level are the same."""
    count = 0.1
    flicker = count * (np.random.default_rng(3).random(COUNT) < 0.1)
    volts = np.where(PLACE // 2 % 2, 3.0, -3.0) + flicker
    assert np.percentile(np.abs(np.diff(volts)), 25) < 1e-9
    assert least_jump(volts) == pytest.approx(CLEAR * count / 2.0**0.5)
    assert jumps(volts).tolist() == list(range(2, COUNT, 2))


def test_two_rows_of_a_level_are_too_few_for_second_differences() -> None:
    volts = np.where(PLACE // 2 % 2, 3.0, -3.0) + NOISE
    assert CLEAR * scatter(volts) > 6.0


@pytest.mark.parametrize("per_row", [3e-3, 0.05, 0.3])
def test_of_a_steady_ramp_neighbours_differ_by_more_than_noise(per_row: float) -> None:
    """Second differences know it; a ramp that turns about keeps its range small."""
    turns = per_row * np.abs((PLACE + 20) % 80 - 40.0) + NOISE
    assert scatter(turns) == pytest.approx(NOISE_V, rel=0.1)
    assert least_jump(turns) == max(CLEAR * scatter(turns), SHARE * float(np.ptp(turns)))


def test_noise_that_grows_is_that_of_the_calm_stretches() -> None:
    loud = NOISE * np.where(PLACE < COUNT // 2, 1.0, 5.0)
    assert least_jump(loud) == pytest.approx(CLEAR * NOISE_V, rel=0.15)


def test_without_noise_a_jump_is_a_share_of_the_range() -> None:
    exact = np.where(PLACE < 100, 0.0, np.where(PLACE < 2000, 4.0, 4.19))
    assert least_jump(exact) == pytest.approx(SHARE * 4.19)
    assert jumps(exact).tolist() == [100]


@pytest.mark.parametrize("count", [130, 400, 2000])
def test_readings_that_hardly_ever_agree_have_no_converter_s_step(count: int) -> None:
    """However few they are: of a ramp, neighbours lie .005 to .08 V apart."""
    ramp = np.linspace(0.0, 10.0, count) + 1e-4 * NOISE[:count] / NOISE_V
    assert count_of(ramp) == 0.0
    assert scatter(ramp) == pytest.approx(1e-4, rel=0.15)


def test_a_converter_s_step_hides_what_neighbours_do_not_show() -> None:
    """Of .05 V, beside noise of a fiftieth of that, and .5 V, which are levels of a command."""
    slow = 5.0 * np.sin(PLACE / 300.0) + 0.01 * NOISE
    fine = 0.05 * np.round(slow / 0.05)
    assert count_of(fine) == pytest.approx(0.05)
    assert scatter(fine) == pytest.approx(0.05 / 12.0**0.5)
    assert count_of(0.5 * np.round(slow / 0.5)) == 0.0


def test_a_voltage_that_swings_within_few_readings_is_no_noise() -> None:
    """Of .28 V, rms, in twelve readings differences of second order leave .03 V."""
    wave = 0.4 * np.sin(2.0 * np.pi * PLACE / 12.0)
    assert scatter(wave + 0.1 * NOISE) == pytest.approx(0.1 * NOISE_V, rel=0.2)
    assert scatter(wave + NOISE) == pytest.approx(NOISE_V, rel=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("deviation", [0.0, 0.2, 0.3, 0.5])
def test_a_mean_keeps_of_rounding_what_noise_does_not_smooth(deviation: float) -> None:
    """In steps of the converter: many readings of levels at random places between two of them."""
    rng = np.random.default_rng(8)
    levels = rng.uniform(0.0, 1.0, (1000, 1))
    noisy = levels + deviation * rng.standard_normal((1000, 3000))
    left = np.round(noisy).mean(axis=1) - levels[:, 0]
    expected = np.sqrt(np.mean(left**2) - deviation**2 / 3000)
    assert rounding(0.1 * deviation, 0.1) == pytest.approx(0.1 * expected, rel=0.25, abs=1e-3)
    assert rounding(deviation, 0.0) == 0.0


@pytest.mark.parametrize("count", [64, 100, 127])
def test_a_short_piece_at_rest_has_no_jumps_but_its_own(count: int) -> None:
    """Too short for calm stretches: its noise was taken for dozens of jumps, an unknown each."""
    rest = NOISE[:count]
    assert scatter(rest) == 0.0
    assert not len(jumps(rest))
    assert jumps(rest + 3.0 * (PLACE[:count] >= 40)).tolist() == [40]


def test_jumps_from_level_to_level_may_be_small() -> None:
    """Ten standard deviations, and less than SHARE of the range."""
    volts = NOISE + 50.0 * (PLACE >= 1000) + 1.0 * (PLACE >= 2000)
    assert jumps(volts).tolist() == [1000]
    found = level_jumps(volts)
    assert found is not None
    assert found.tolist() == changes(volts).tolist() == [1000, 2000]


@pytest.mark.parametrize(("apart", "alone"), [(3, False), (4, True)])
def test_changes_of_readings_on_end_are_no_jumps_between_levels(apart: int, alone: bool) -> None:
    """As of terminals behind a source, while the current rises."""
    volts = NOISE + 3.0 * (PLACE >= 1000) + 2.0 * (1000 + apart <= PLACE)
    assert changes(volts).tolist() == [1000, 1000 + apart]
    assert (level_jumps(volts) is not None) is alone
    assert level_jumps(NOISE + 3.0 * (PLACE >= 3)) is None  # a level has begun before the log


@pytest.mark.parametrize(("every", "levels"), [(15, False), (20, True)])
def test_a_voltage_that_jumps_often_has_no_levels(every: int, levels: bool) -> None:
    volts = NOISE + 3.0 * (PLACE // every % 2)
    assert (level_jumps(volts) is not None) is levels


def in_steps(seldom: int, level_v: float = 6.02) -> np.ndarray:
    """A level in steps of .05 V, of which every so many readings show the next one."""
    step = 0.05
    return step * (np.round(level_v / step) + (PLACE % seldom == 7))


@pytest.mark.parametrize(("seldom", "rounded"), [(COUNT // 8, True), (COUNT // 7, False)])
def test_steps_that_noise_hardly_ever_crosses_are_a_converters(seldom: int, rounded: bool) -> None:
    """Three quarters of the stretches are still: where the level lies in its step nobody knows."""
    volts = in_steps(seldom) - 12.0 * (PLACE > COUNT // 2)
    assert scatter(volts) == pytest.approx(0.05 / np.sqrt(12.0) if rounded else 0.0)


def test_levels_of_a_command_that_differ_by_little_have_no_scatter() -> None:
    """In steps of .05 V as well, but none comes back at once."""
    volts = 6.0 + 0.05 * (PLACE // 500 % 2) - 12.0 * (PLACE > COUNT // 2)
    assert count_of(volts) == pytest.approx(0.05)
    assert scatter(volts) == 0.0
