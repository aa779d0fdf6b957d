"""Whether a rotor stands, by counts and readings that were written down."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture, Channel
from motorid.estimate.signals import standstill as module
from motorid.estimate.signals.standstill import starts_at_rest, with_standstill
from motorid.estimate.signals.time_grid import Part, lay
from motorid.program import StepKind
from tests.estimate.signals.test_time_grid import COAST, capture, drive

Floats = NDArray[np.float64]
DRIVEN, OPEN = np.ones(100, dtype=bool), np.zeros(100, dtype=bool)
BY_TURNS = (-1.0) ** np.arange(100)
LATER = 5.0 * np.maximum(np.arange(100.0) - 50.0, 0.0)


def run(place: Floats, resolution: float = 0.5, level: float = 0.5) -> Capture:
    """A rest, a part of 40 samples that is driven, and a rest."""
    read = Channel(POSITION, "rad", place, resolution=resolution)
    return capture(
        100 * np.arange(100), COAST, drive(level), COAST, starts=(0, 1900, 5900), position=read
    )


def stands(place: Floats, **how: float) -> list[bool]:
    one = run(place, **how)
    return [part.still for part in with_standstill(one, lay(one)).parts]


def place(counts: float, known: int = 40) -> Floats:
    """At the end of the part so many counts of half a radian further, amid it unknown."""
    out = np.zeros(100)
    out[59] = 0.5 * counts
    out[20 : 60 - known] = np.nan
    return out


@pytest.mark.parametrize(
    ("counts", "still"), [(0.0, True), (1.0, True), (1.5, True), (1.6, False), (-2.0, False)]
)
def test_a_rotor_stands_within_a_count_and_a_half(counts: float, still: bool) -> None:
    assert stands(place(counts)) == [False, still, False]


@pytest.mark.parametrize(("known", "still"), [(23, False), (24, True)])
def test_enough_readings_tell_it(known: int, still: bool) -> None:
    assert stands(place(0.0, known))[1] is still


def test_a_part_at_no_level_or_an_encoder_without_counts_tells_nothing() -> None:
    assert stands(place(0.0), level=0.0) == [False] * 3
    one = run(place(0.0), resolution=0.0)
    line = lay(one)
    assert with_standstill(one, line) is line
    free = replace(run(place(0.0)), program=None, phases=())
    parts = (Part(0, 100, StepKind.DRIVE_DUTY, 0.5),)
    whole = replace(line, parts=parts)
    assert with_standstill(free, whole) is whole


def at_rest(driven: NDArray[np.bool_] = DRIVEN, **channels: Any) -> bool:
    units = {POSITION: "rad", SPEED: "rad/s", CURRENT: "A"}
    made = {
        n: c
        if isinstance(c, Channel)
        else Channel(n, units[n], np.asarray(c, float), resolution=0.1)
        for n, c in channels.items()
    }
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return starts_at_rest(Capture(100 * np.arange(100), 1e6, made), driven)


@pytest.mark.parametrize("offset", [0.0, 5.0])
@pytest.mark.parametrize(
    ("by_turns", "shift", "rests"),
    [
        (0.0, 0.14, True),  # a count and a half
        (0.0, 0.16, False),
        (0.0, -0.16, False),
        (0.1, 0.52, True),  # differences of .2 by turns: twice their .198, and .15
        (0.1, 0.57, False),
    ],
)
def test_a_position_moves_by_more_than_it_scatters(
    offset: float, by_turns: float, shift: float, rests: bool
) -> None:
    """The second eight readings beside the first, of a motor that is fast for its encoder later."""
    read = offset + by_turns * BY_TURNS + np.where(np.arange(100) < 8, 0.0, shift)
    assert at_rest(position=read + LATER) is rests


@pytest.mark.parametrize(
    ("counts", "head"),
    [(0.0, 128), (0.04, 128), (0.05, 120), (0.25, 24), (0.3, 24), (0.7, 16), (0.8, 8), (9.0, 8)],
)
def test_a_slow_motor_shows_its_motion_over_six_counts(counts: float, head: int) -> None:
    """``counts`` in a sample, of .1 rad. What eight samples show of so slow a one is a flicker."""
    at = np.arange(400.0)
    read = Channel(POSITION, "rad", 0.1 * counts * at, resolution=0.1)
    assert module._head(read) == head
    assert module._head(replace(read, resolution=0.0)) == 8
    turns = replace(read, raw=0.1 * np.floor(counts * at), resolution=0.1)
    assert module._moves(turns) is (counts > 0.0)


def test_a_short_log_of_a_slow_motor_shows_as_much_as_it_has() -> None:
    """Of 100 readings the last are fewer than the first; of 8 there are none."""
    slow = 0.1 * np.floor(0.05 * np.arange(100.0))
    assert at_rest(position=slow) is False
    for count in (8, 9):
        short = Channel(POSITION, "rad", slow[:count], resolution=0.1)
        assert module._moves(short) is False


@pytest.mark.parametrize("unknown", [slice(0, 8), slice(8, 16)])
def test_a_position_that_was_not_read_shows_no_motion(unknown: slice) -> None:
    read = np.arange(100.0)
    read[unknown] = np.nan
    assert at_rest(position=read) is True
    assert at_rest(position=np.arange(100.0)) is False


@pytest.mark.parametrize("name", [SPEED, CURRENT])
@pytest.mark.parametrize(
    ("by_turns", "mean", "rests"),
    [
        (0.0, 0.09, True),  # within its resolution
        (0.0, -0.11, False),
        (0.1, 0.68, True),  # differences of .2 by turns: thrice that, and .1
        (0.1, 0.72, False),
    ],
)
def test_a_speed_or_current_is_nothing_within_its_scatter(
    name: str, by_turns: float, mean: float, rests: bool
) -> None:
    assert at_rest(**{name: mean + by_turns * BY_TURNS}) is rests


def test_what_comes_later_says_nothing_of_the_beginning() -> None:
    """Eight readings of it, and the scatter of the first sixty-four."""
    late = np.full(100, 0.2)
    late[70:] = 50.0
    assert at_rest(speed=late) is False
    ramp = np.maximum(np.arange(100.0) - 7.0, 0.0)
    assert at_rest(speed=0.2 * ramp) is True


@pytest.mark.parametrize("known", [slice(80, 100), slice(8, 100), slice(0, 1)])
def test_a_speed_that_was_not_read_shows_no_rest(known: slice) -> None:
    """Not at the beginning, or once: no difference tells its scatter."""
    read = np.full(100, np.nan)
    read[known] = 0.0
    assert at_rest(speed=read) is False


def test_a_current_counts_where_the_bridge_is_closed_as_the_run_begins() -> None:
    flows = np.full(100, 2.0)
    closes = OPEN.copy()
    closes[1:] = True
    assert at_rest(DRIVEN, current=flows) is False
    assert at_rest(OPEN, current=flows) is True
    assert at_rest(closes, current=flows) is True
    assert at_rest(~closes, current=flows) is False
    assert at_rest(DRIVEN) is True


def test_a_log_of_few_readings_a_motion_does_not_scatter_by_its_motion() -> None:
    """Steps of 1 A a reading, from reading 8 on; the first eight show no current, or .5 A."""
    course = np.where(np.arange(100) < 8, 0.0, np.arange(100) % 5 - 2.0)
    noise = 0.01 * np.random.default_rng(2).standard_normal(100)
    for begins, rests in ((0.0, True), (0.5, False)):
        current = course + noise + np.where(np.arange(100) < 8, begins, 0.0)
        assert at_rest(current=current) is rests
