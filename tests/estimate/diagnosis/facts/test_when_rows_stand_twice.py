"""Rows that stand twice: how many there must be, where, and what they do, by hand-made tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.facts.doubled_rows import (
    FAR,
    _catch_up,
    _moves,
    _moving,
    find,
    findings,
)
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from motorid.program import Program, Step, StepKind
from tests.estimate.diagnosis.facts.made_log import rows

Floats = NDArray[np.float64]


def waves(count: int, still: int = 0) -> Capture:
    """Two channels that always move, but for the last ``still`` rows; no row is like another."""
    k = np.minimum(np.arange(count), count - still)
    volts, amps = 5.0 * np.sin(0.013 * k), 2.0 * np.cos(0.017 * k + 0.3)
    channels = {VOLTAGE: Channel(VOLTAGE, "V", volts), CURRENT: Channel(CURRENT, "A", amps)}
    return Capture(500 * np.arange(count), 1e6, channels)


def twice(capture: Capture, places: Sequence[int]) -> Capture:
    """The same, these rows twice."""
    times = np.ones(len(capture), dtype=int)
    times[list(places)] = 2
    return rows(capture, np.repeat(np.arange(len(capture)), times))


def spaced(count: int, first: int = 20, apart: int = 20) -> list[int]:
    return [first + apart * k for k in range(count)]


def test_rows_are_counted_and_their_time_is_said() -> None:
    capture = twice(waves(600), spaced(12))
    assert list(find(capture)) == [21 + 21 * k for k in range(12)]
    (said,) = findings(capture, {}, " in run 2")
    assert said.code == "rows_doubled"
    assert said.message.startswith(
        "12 rows stand twice in run 2, all channels alike where the readings move, first at 0.0105 "
        "s, and the stamps count them as new: time runs 2 % too long"
    )


@pytest.mark.parametrize(("count", "few", "enough"), [(400, 9, 10), (6000, 30, 31)])
def test_ten_rows_are_enough_and_a_two_hundredth_of_all(count: int, few: int, enough: int) -> None:
    assert len(find(twice(waves(count), spaced(few)))) == 0
    assert len(find(twice(waves(count), spaced(enough)))) == enough


def back(capture: Capture, places: Sequence[int]) -> Capture:
    """The same, whose readings are there what they were two rows before."""
    channels = {}
    for name, channel in capture.channels.items():
        raw = np.array(channel.raw)
        for k in places:
            raw[k] = raw[k - 2]
        channels[name] = replace(channel, raw=raw)
    return replace(capture, channels=channels)


@pytest.mark.parametrize(
    ("chance", "doubled", "named"), [(2, 14, False), (2, 16, True), (0, 10, True), (1, 10, True)]
)
def test_they_are_much_oftener_than_rows_that_come_back_by_chance(
    chance: int, doubled: int, named: bool
) -> None:
    """Five times as often as those and one more."""
    capture = back(twice(waves(1000), spaced(doubled)), [700 + 50 * k for k in range(chance)])
    assert bool(len(find(capture))) is named


@pytest.mark.parametrize(("still", "named"), [(380, True), (520, False)])
def test_readings_that_stay_for_half_of_the_time_say_nothing(still: int, named: bool) -> None:
    assert bool(len(find(twice(waves(1000, still), spaced(12))))) is named


def test_a_row_near_an_end_a_run_of_three_and_one_that_takes_no_time_are_none() -> None:
    inside = spaced(11, first=30)
    for place, more in ((7, 1), (6, 0), (591, 1), (592, 0)):
        found = find(twice(waves(600), sorted([*inside, place])))
        assert len(found) == 11 + more, place
    thrice = rows(waves(600), np.sort(np.r_[np.arange(600), inside, 300, 300]))
    assert len(find(thrice)) == 11
    capture = twice(waves(600), inside)
    ticks = np.array(capture.ticks)
    ticks[31:] -= 300  # the first comes 0.2 ms after its like: less than half of a period
    assert len(find(replace(capture, ticks=ticks))) == 10
    ticks[31:] += 100  # or 0.3 ms after
    assert len(find(replace(capture, ticks=ticks))) == 11


def test_one_channel_a_program_or_a_few_rows_tell_nothing() -> None:
    capture = twice(waves(600), spaced(12))
    assert len(find(capture)) == 12
    alone = {VOLTAGE: capture.channels[VOLTAGE]}
    assert len(find(replace(capture, channels=alone))) == 0
    program = Program((Step(StepKind.COAST, 1.0),))
    assert len(find(replace(capture, program=program))) == 0
    assert len(find(waves(4 * FAR - 1))) == 0


def test_a_row_moves_where_a_channel_changes_by_three_steps_on_both_sides() -> None:
    """Row k is like row k - 1: what counts is the change after k, and that before k - 1."""
    one = np.array([1.0, 3.0, 0.0, -3.0, 2.0, 1.0, 4.0, 0.0, 5.0])
    other = np.array([7.0, 7.0, 0.0, 14.0, 7.0, 21.0, 0.0, 0.0, 35.0])
    assert list(np.flatnonzero(_moving(one[:, None], 1))) == [3, 8]
    assert list(np.flatnonzero(_moving(other[:, None], 1))) == []
    both = np.column_stack([one, other])
    assert list(np.flatnonzero(_moving(both, 1))) == [3, 8]
    # a row that is like the one before the last: the change after k, and that before k - 2
    assert list(np.flatnonzero(_moving(one[:, None], 2))) == [6]
    assert list(np.flatnonzero(_moving(other[:, None], 2))) == [8]


SLOPES = (1.0, -2.0, 3.0)  # of a signal, about each of three rows that are like the one before
PLACES = np.array([20, 60, 100])


def ramp(after: float) -> Floats:
    """It goes on by so many usual changes after each of them."""
    steps = np.repeat(SLOPES, 40)
    steps[PLACES] = 0.0
    steps[PLACES + 1] *= after
    return np.cumsum(steps)


@pytest.mark.parametrize("after", [0.5, 1.0, 2.0])
def test_a_change_after_a_repetition_is_counted_in_usual_ones(after: float) -> None:
    assert _catch_up(ramp(after)[:, None], PLACES) == pytest.approx(after)


@pytest.mark.parametrize("order", [1, -1])
def test_the_channel_that_moves_most_clearly_says_so(order: int) -> None:
    """The one goes on evenly; the other shakes by a millionth of its changes."""
    shaken = ramp(2.0) + 1e-6 * np.random.default_rng(1).standard_normal(120)
    table = np.column_stack([ramp(1.0), shaken][::order])
    assert _catch_up(table, PLACES) == pytest.approx(1.0)
    shaken = 1e3 * (ramp(2.0) + 0.02 * np.random.default_rng(1).standard_normal(120))
    calm = ramp(1.0) + 0.01 * np.random.default_rng(2).standard_normal(120)
    table = np.column_stack([calm, shaken][::order])
    assert _catch_up(table, PLACES) == pytest.approx(1.0, abs=0.1)


def test_a_channel_that_turns_back_beside_a_repetition_tells_nothing() -> None:
    """Its changes beside it are not what it does about it."""
    turned = np.array(ramp(1.0))
    for k in PLACES:
        turned[k - 2 : k + 3] = turned[k - 2 : k + 3][::-1].copy()
    assert _catch_up(turned[:, None], PLACES) == 1.0
    assert _catch_up(np.column_stack([turned, ramp(2.0)]), PLACES) == pytest.approx(2.0)


def parameters(**values: float | None) -> dict[str, Parameter]:
    return {
        n: Parameter(n, "", v, None, None, None, None, Status.ESTIMATED) for n, v in values.items()
    }


def test_time_that_is_too_long_moves_what_is_timed_and_by_chance_more() -> None:
    """J by JR/K² = 40 ms, 80 rows; L by L/R = 2 ms, 4 rows; the share of rows is a hundredth."""
    known = parameters(R=2.0, L=4e-3, K=0.1, B=1e-5, J=2e-4, T0=0.0)
    channels = {**waves(50).channels, SPEED: Channel(SPEED, "rad/s", np.zeros(50))}
    told = replace(waves(50), channels=channels)
    found = _moves(told, known, 0.01)
    sizes = {
        "J": 2e-4 * (0.01 + 2.0 * math.sqrt(0.01 / 80.0)),
        "L": 4e-3 * (0.01 + 2.0 * math.sqrt(0.01 / 4.0)),
    }
    assert found == pytest.approx(sizes)
    fast = _moves(told, {**known, **parameters(L=1e-6)}, 0.01)
    assert fast["L"] == pytest.approx(1e-6 * 0.21)  # less than a row counts as one
    without = {n: p for n, p in known.items() if n != "L"}
    assert _moves(told, without, 0.01) == pytest.approx({"J": sizes["J"]})
    turned = {VOLTAGE: channels[VOLTAGE], POSITION: Channel(POSITION, "rad", np.zeros(50))}
    by_position = _moves(replace(told, channels=turned), known, 0.01)
    assert by_position == pytest.approx({**sizes, "K": 1e-3, "B": 1e-7})


def test_how_far_is_open_without_what_the_times_follow_from() -> None:
    known = parameters(R=2.0, L=None, J=2e-4, B=0.0, T0=1e-3)
    found = _moves(waves(50), known, 0.01)
    assert found == {"R": math.inf, "J": math.inf, "T0": math.inf}
