"""Rows that a log lacks under renewed stamps are named; no jump that a motor makes is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE
from motorid.estimate.diagnosis.faults import lost_rows
from motorid.estimate.diagnosis.faults.lost_rows import _Lines, find, suspects
from tests.estimate.diagnosis.facts.made_log import LEVEL_S, PERIOD_S, log, rounded, rows, truth

LEVEL = round(LEVEL_S / PERIOD_S)  # rows


def test_rows_that_are_missing_are_named() -> None:
    capture = log(0.3)
    kept = np.flatnonzero(np.random.default_rng(2).random(len(capture)) > 0.02)
    (said,) = suspects(rows(capture, kept))
    assert said.code == "samples_dropped"
    assert "whole rows" in said.evidence
    assert said.moves["J"] == np.inf


def test_a_position_turns_farther_in_the_time_that_is_left() -> None:
    """A K that is 5 % less makes a motor 5 % faster; of B, speed and torque are both off."""
    capture = log(0.3)
    angle = np.cumsum(truth()[SPEED]) * PERIOD_S
    turned = replace(capture.channels[SPEED], name=POSITION, unit="rad", raw=angle, scale=1.0)
    channels = {n: c for n, c in capture.channels.items() if n != SPEED} | {POSITION: turned}
    kept = np.flatnonzero(np.random.default_rng(2).random(len(capture)) > 0.02)
    cut = rows(replace(capture, channels=channels), kept)
    motor = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    (said,) = suspects(cut, motor)
    lost = find(cut)
    assert lost is not None
    share = lost.rows.sum() / len(cut)
    assert 0.0 < share < 0.03
    expected = {"L": np.inf, "J": np.inf, "K": 3.0 * share, "B": 8.0 * share, "T0": 6.0 * share}
    assert said.moves == pytest.approx(expected)
    assert suspects(cut)[0].moves == {"L": np.inf, "J": np.inf}


def test_a_stretch_that_was_cut_out_is_named() -> None:
    capture = log()
    begin = 2 * LEVEL + 20
    kept = np.r_[:begin, begin + 120 : len(capture)]
    (said,) = suspects(rows(capture, kept))
    assert "a stretch is missing" in said.evidence
    assert f"{begin * PERIOD_S:.4g} s" in said.evidence


@pytest.mark.parametrize("noise", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("bits", [0, 8, 12])
def test_a_whole_log_is_not_accused(noise: float, bits: int) -> None:
    assert suspects(rounded(log(noise), bits)) == []


@pytest.mark.parametrize("late", [1, 5, 12])
def test_a_late_current_is_not_accused(late: int) -> None:
    shown = np.r_[np.zeros(late), truth()[CURRENT][:-late]]
    assert suspects(log(0.3, **{CURRENT: shown})) == []


def test_a_sensor_that_fails_for_a_while_is_no_missing_row() -> None:
    speed = truth()[SPEED].copy()
    speed[3 * LEVEL - 40 : 3 * LEVEL - 20] = 0.0
    assert suspects(log(**{SPEED: speed})) == []


def test_a_pause_that_the_stamps_show_is_not_accused() -> None:
    capture = log()
    kept = np.r_[: 2 * LEVEL + 20, 2 * LEVEL + 140 : len(capture)]
    stamped = replace(rows(capture, kept), ticks=capture.ticks[kept])
    assert suspects(stamped) == []


@pytest.mark.parametrize("seed", range(3))
def test_pauses_that_a_busy_computer_leaves_now_and_then_are_not_accused(seed: int) -> None:
    capture, rng = log(0.3), np.random.default_rng(seed)
    steps = np.where(rng.random(len(capture)) < 0.02, rng.integers(3, 7, len(capture)), 1)
    kept = np.cumsum(steps)
    kept = kept[kept < len(capture)]
    stamped = replace(rows(capture, kept), ticks=capture.ticks[kept])
    assert suspects(stamped) == []


@pytest.mark.parametrize("count", [1.0, 3.07])
def test_a_coarse_channel_that_mostly_stays_is_not_taken_for_exact(count: float) -> None:
    """Edges a row: its usual third difference is nothing, and a line through it is known to about a
    third of a count, not to a millionth of its range.
    """
    rng = np.random.default_rng(3)
    speed = count * (30.0 + (rng.random(600) < 0.1))
    lines = _Lines.of(speed, 10)
    assert count / 5 < np.sqrt(lines.variance) < count
    assert np.abs(lines.jump).max() < 5 * np.sqrt(lines.variance)


def test_a_smooth_channel_stays_exact() -> None:
    speed = 400.0 * (1.0 - np.exp(-np.arange(600) / 80.0))
    assert np.sqrt(_Lines.of(speed, 10).variance) < 0.01


@pytest.mark.parametrize("side", [5, 10])
def test_lines_are_fitted_to_so_many_readings_on_either_side(side: int) -> None:
    values = np.cumsum(np.random.default_rng(6).standard_normal(60))
    lines = _Lines.of(values, side)
    assert len(lines.jump) == 60 - 2 * side + 1
    for k in (0, 7, 60 - 2 * side):
        before, after = values[k : k + side], values[k + side : k + 2 * side]
        middle = side - 0.5  # between both
        left = np.polyfit(np.arange(side), before, 1)
        right = np.polyfit(np.arange(side, 2 * side), after, 1)
        assert lines.before[k] == pytest.approx(left[0])
        assert lines.after[k] == pytest.approx(right[0])
        assert lines.jump[k] == pytest.approx(np.polyval(right, middle) - np.polyval(left, middle))
    same = lines.before * lines.after > 0.0
    assert lines.slope[same] == pytest.approx((lines.before + lines.after)[same] / 2)
    assert not lines.slope[~same].any()


def test_the_variance_of_a_jump_is_that_of_two_lines_in_noise() -> None:
    rng = np.random.default_rng(7)
    noise = rng.normal(0.0, 0.2, 40_000)
    lines = _Lines.of(noise, 8)
    assert lines.variance == pytest.approx(float(np.var(lines.jump)), rel=0.05)
    assert lost_rows._noise(noise) == pytest.approx(0.2, rel=0.03)
    assert lost_rows._noise(np.linspace(0.0, 5.0, 50)) == pytest.approx(5e-6)


def test_a_small_step_is_the_resolution_of_a_coarse_channel() -> None:
    coarse = 0.5 * np.round(np.linspace(0.0, 10.0, 200))
    assert lost_rows._step(coarse) == pytest.approx(0.5)
    assert lost_rows._step(np.full(20, 3.0)) == 0.0
    rounded_again = coarse * (1.0 + 1e-12 * np.arange(200))  # by a change of units
    assert lost_rows._step(rounded_again) == pytest.approx(0.5, rel=1e-6)


def test_a_voltage_that_bends_beside_a_place_or_a_little_before_it_excuses_a_jump() -> None:
    volts = np.random.default_rng(8).normal(0.0, 1e-3, 200)
    volts[100:] += 1.0
    late, side = 6, 5
    steady = lost_rows._steady(volts, late, side)
    assert len(steady) == 200 - 2 * side + 1
    places = np.flatnonzero(~steady) + side  # rows after a place
    assert places.min() == 100 - side + 1
    assert places.max() == 100 + side - 1 + late


def test_a_place_at_which_the_stamps_pause_is_not_even() -> None:
    time = np.arange(40.0)
    time[20:] += 0.6
    even = lost_rows._even(time, 5)
    assert (np.flatnonzero(~even) + 5).tolist() == list(range(16, 25))  # lines of 5 meet there
    time[20:] -= 0.2
    assert lost_rows._even(time, 5).all()


def test_a_peak_is_the_largest_of_its_neighbours() -> None:
    missing = np.array([0.0, 1.0, -3.0, 2.0, 0.0, 0.0, 0.0, 1.0])
    assert lost_rows._peaks(missing, 2).tolist() == [
        False, False, True, False, False, False, False, True,
    ]  # fmt: skip


def test_what_lies_beside_a_place_touches_its_lines_on_one_side() -> None:
    values, side = np.zeros(41), 3
    values[20] = 1.0
    found = np.flatnonzero(lost_rows._beside(values, side)) - 20
    assert sorted(np.abs(found).tolist()) == [4, 4, 5, 5, 6, 6]


@pytest.mark.parametrize("rows_lost", [1, 2])
def test_as_many_rows_are_missing_as_were_left_out(rows_lost: int) -> None:
    capture = log(0.1)
    places = [k * LEVEL + 30 for k in range(1, 5)]
    gone = [p + j for p in places for j in range(rows_lost)]
    found = find(rows(capture, np.setdiff1d(np.arange(len(capture)), gone)))
    assert found is not None
    before = [p - rows_lost * k for k, p in enumerate(places)]
    assert found.places.tolist() == before
    assert found.rows.tolist() == [rows_lost] * 4
    (said,) = suspects(rows(capture, np.setdiff1d(np.arange(len(capture)), gone)))
    assert (
        f"at 4 places, first at {before[0] * PERIOD_S:.4g} s: {4 * rows_lost} rows" in said.evidence
    )


def test_few_places_are_chance() -> None:
    capture = log(0.1)
    gone = [LEVEL + 30, 2 * LEVEL + 30]
    assert find(rows(capture, np.setdiff1d(np.arange(len(capture)), gone))) is None


def test_nothing_is_said_where_nothing_can_be() -> None:
    capture = rows(log(0.1), np.delete(np.arange(6 * LEVEL), [k * LEVEL + 30 for k in range(1, 5)]))
    assert find(capture) is not None
    without = {n: c for n, c in capture.channels.items() if n != VOLTAGE}
    assert find(replace(capture, channels=without)) is None
    alone = {n: c for n, c in capture.channels.items() if n not in (CURRENT, SPEED, POSITION)}
    assert find(replace(capture, channels=alone)) is None
    holed = replace(capture.channels[SPEED], raw=np.r_[np.nan, capture.channels[SPEED].raw[1:]])
    assert find(replace(capture, channels={**capture.channels, SPEED: holed})) is None
    assert find(rows(capture, np.arange(159))) is None
