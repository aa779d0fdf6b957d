"""Channels at odds with each other: magnitudes, units, columns that never change."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motorid.capture import table_checks as checks
from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel

NAN = float("nan")
ROUGH = np.array([6.0] * 6 + [0.0] * 2 + [-6.0] * 6)  # V


def channel(name: str, values: Any, **facts: Any) -> Channel:
    return Channel(name, "", np.asarray(values, dtype=float), **facts)


def unsigned(**values: Any) -> tuple[list[str], list[str]]:
    """The channels that are taken as magnitudes, and the notes."""
    notes: list[str] = []
    given = {name: channel(name, column) for name, column in values.items()}
    found = checks.with_magnitudes(given, notes)
    assert list(found) == list(given)
    return [name for name, one in found.items() if one.unsigned], notes


SPEEDS = np.array([2.0, 8.0, 9.0, 9.0, 9.0, 9.0, 4.0, 0.0, 0.0, 5.0, 9.0, 9.0, 9.0, 9.0])


def test_a_speed_that_grows_both_ways_after_a_rest_is_a_magnitude() -> None:
    names, notes = unsigned(**{VOLTAGE: ROUGH, SPEED: SPEEDS})
    assert names == [SPEED]
    assert notes == ["the speed is never negative though the voltage drives both ways: a magnitude"]


@pytest.mark.parametrize(
    "speeds",
    [
        np.where(ROUGH < 0, -SPEEDS, SPEEDS),  # it has a sign
        np.where(ROUGH < 0, 0.0, SPEEDS),  # it never ran backward
        [2.0, 8.0, 9.0, 9.0, 9.0, 9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0],  # it only slowed
        [NAN, NAN, *SPEEDS[2:]],  # four readings forward are too few
        [*SPEEDS[:-2], NAN, NAN],
    ],
)
def test_speeds_that_are_no_magnitudes(speeds: Any) -> None:
    assert unsigned(**{VOLTAGE: ROUGH, SPEED: speeds}) == ([], [])


def test_a_current_is_judged_by_the_way_of_the_speed() -> None:
    speed = np.where(ROUGH < 0, -SPEEDS, SPEEDS)
    names, notes = unsigned(**{SPEED: speed, CURRENT: np.full(14, 0.3)})
    assert names == [CURRENT]
    assert notes == ["the current is never negative though the motor runs both ways: a magnitude"]
    assert unsigned(**{SPEED: speed, CURRENT: 0.3 * np.sign(speed)}) == ([], [])
    assert unsigned(**{CURRENT: np.full(14, 0.3)}) == ([], [])
    current, way = np.full(14, 0.3), speed.copy()
    current[2], way[3] = NAN, NAN  # a missing reading of either says nothing
    assert unsigned(**{SPEED: way, CURRENT: current})[0] == [CURRENT]


def test_a_current_beside_an_unsigned_speed_is_judged_by_the_voltage() -> None:
    names, notes = unsigned(**{VOLTAGE: ROUGH, SPEED: SPEEDS, CURRENT: np.full(14, 0.3)})
    assert names == [SPEED, CURRENT]
    assert len(notes) == 2
    names, _ = unsigned(**{VOLTAGE: np.abs(ROUGH), SPEED: SPEEDS, CURRENT: np.full(14, 0.3)})
    assert names == []


@pytest.mark.parametrize(("slow", "magnitude"), [(-1.9, False), (-2.1, True)])
def test_only_what_is_beyond_a_fifth_of_the_largest_counts_as_a_way(
    slow: float, magnitude: bool
) -> None:
    way = np.array([10.0] * 5 + [slow] * 5)
    names, _ = unsigned(**{SPEED: way, CURRENT: np.full(10, 0.3)})
    assert (names == [CURRENT]) is magnitude


def test_a_current_of_nothing_one_way_is_no_magnitude() -> None:
    way = np.array([10.0] * 5 + [-10.0] * 5)
    assert unsigned(**{SPEED: way, CURRENT: [0.3] * 5 + [0.0] * 5}) == ([], [])
    assert unsigned(**{SPEED: way, CURRENT: [0.0] * 5 + [0.3] * 5}) == ([], [])


def test_what_is_stated_unsigned_is_not_noted() -> None:
    notes: list[str] = []
    given = {
        SPEED: channel(SPEED, SPEEDS, unsigned=True),
        VOLTAGE: channel(VOLTAGE, ROUGH),
        CURRENT: channel(CURRENT, np.full(14, 0.3), unsigned=True),
    }
    assert checks.with_magnitudes(given, notes)[CURRENT].unsigned
    assert not notes


# -- a speed beside a position
TIMES = np.array([0.0, 1.0, 2.0, 4.0, 5.0])
SPEED_THEN = np.array([0.0, 2.0, 4.0, -2.0, 0.0])
TRAVELLED = np.array([0.0, 1.0, 4.0, 6.0, 5.0])  # by hand: 1, 3, 2 and -1
ACROSS = np.array([1.0, -1.0, 1.0, -1.0, 0.0])


@pytest.mark.parametrize("factor", [1.0, 0.25, -3.0])
def test_the_factor_between_speed_and_the_derivative_of_position(factor: float) -> None:
    ratio = checks.speed_over_derivative(TIMES, TRAVELLED / factor + 11.0, SPEED_THEN)
    assert ratio == pytest.approx(factor)


@pytest.mark.parametrize(
    ("position", "speed"), [(np.full(5, 3.0), SPEED_THEN), (TRAVELLED, np.zeros(5))]
)
def test_what_stands_still_gives_no_factor(position: Any, speed: Any) -> None:
    assert checks.speed_over_derivative(TIMES, position, speed) is None


@pytest.mark.parametrize(("share", "known"), [(0.88, False), (0.92, True)])
def test_a_position_that_goes_another_way_gives_no_factor(share: float, known: bool) -> None:
    travelled = TRAVELLED - TRAVELLED.mean()
    across = ACROSS - travelled * (ACROSS @ travelled) / (travelled @ travelled)
    across *= np.sqrt((travelled @ travelled) / (across @ across))
    position = travelled + np.sqrt(1.0 / share - 1.0) * across  # whose cosine squared is the share
    ratio = checks.speed_over_derivative(TIMES, position, SPEED_THEN)
    assert ratio == (pytest.approx(share) if known else None)


def notes_of(position: Any, speed: Any, static: bool = False, **held: int) -> list[str]:
    ticks = np.rint(TIMES * 1e9).astype(np.int64)
    channels = {POSITION: channel(POSITION, position), SPEED: channel(SPEED, speed)}
    return checks.capture_notes(Capture(ticks, 1e9, channels), held, static)


@pytest.mark.parametrize(
    ("factor", "said"), [(0.91, None), (1.09, None), (0.89, "0.89"), (1.11, "1.11")]
)
def test_a_factor_beyond_a_tenth_is_noted(factor: float, said: str | None) -> None:
    notes = notes_of(TRAVELLED, factor * SPEED_THEN)
    assert [note.partition(" times")[0] for note in notes] == ([f"speed is {said}"] if said else [])
    assert notes_of(TRAVELLED, factor * SPEED_THEN, static=True) == []


def test_a_missing_reading_of_either_is_left_out_of_the_factor() -> None:
    fast = 2.0 * SPEED_THEN
    assert notes_of([*TRAVELLED[:4], NAN], fast)[0].startswith("speed is 2 times")
    assert notes_of(TRAVELLED, [0.0, NAN, *fast[2:]])[0].startswith("speed is 2 times")
    assert notes_of([NAN] * 3 + [1.0, 2.0], [3.0, 3.0, 3.0, NAN, 4.0]) == []


def test_columns_that_never_change_or_are_held_are_noted() -> None:
    assert notes_of([NAN, 3.0, 3.0, 3.0, NAN], SPEED_THEN, current=7) == [
        "position never changes: is it the right column?",
        "current is held: it changes only every 7 samples",
    ]


@pytest.mark.parametrize(
    ("values", "backward", "counted"),
    [
        ([9, 9, 0, 5, 6, 7], "...bbb", "...xxx"),  # the motor started from the reading before
        ([0, 9, 9, 5, 6, 7], "...bbb", "......"),  # an earlier rest says nothing
        ([9, 9, 5, 0, 6, 7], "..bbbb", "...xxx"),
        ([0, 5, 6, 9, 9, 9], "bbb...", "xxx..."),
        ([9, 5, 0, 9, 0, 9], "bb..bb", "....xx"),
        ([9, 5, 1, 6, 9, 9], "bbbb..", "......"),  # 1 is no rest yet
        ([9, 0, 0, 6, 0, 9], ".bbb.b", ".xxx.x"),
    ],
)
def test_a_stretch_counts_from_its_rest_on(values: Any, backward: str, counted: str) -> None:
    stretches = np.array([one == "b" for one in backward])
    found = checks._after_rest(np.array(values, dtype=float), stretches, 1.0)
    assert "".join("x" if one else "." for one in found) == counted


@pytest.mark.parametrize(("least", "magnitude"), [(-0.029, True), (-0.031, False)])
def test_noise_below_zero_leaves_a_magnitude(least: float, magnitude: bool) -> None:
    speed = np.where(ROUGH < 0, -SPEEDS, SPEEDS)
    current = np.full(14, 0.3)
    current[7] = least  # at rest
    names, _ = unsigned(**{SPEED: speed, CURRENT: current})
    assert (names == [CURRENT]) is magnitude
