"""How straight pieces get their names: each rule on both sides of its bound, by made pieces."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel, Gap
from motorid.segment import classify, split
from motorid.segment.blocks import Blocks, Signal
from motorid.segment.classify import ACCELERATION, BRAKE, COAST, REST, STEADY, Course, course
from motorid.segment.pieces import Pieces
from motorid.segment.types import Segment, SegmentKind

A, B, C, R, S = ACCELERATION, BRAKE, COAST, REST, STEADY


def blocks(count: int, sigma: float = 0.0, scale: float = 100.0, **facts: Any) -> Blocks:
    """Blocks of one sample and a second each, whose speed no rule of these looks at."""
    start = np.arange(count)
    made = Blocks(
        start=start, stop=start + 1, time_s=start.astype(float),
        joined=np.ones(count - 1, dtype=bool),
        speed=Signal(np.zeros(count), sigma, sigma, scale), still=0.0, drive=None, drive_zero=None,
        speed_samples=np.zeros(count), drive_samples=None,
    )  # fmt: skip
    return replace(made, **facts)


def pieces(counts: list[int], levels: Any, slopes: Any, errors: Any = None) -> Pieces:
    """Pieces of so many blocks after one another."""
    stop = np.cumsum(counts)
    first = stop - counts
    level, slope = (np.array(x, dtype=float).reshape(len(counts), -1) for x in (levels, slopes))
    error = np.zeros_like(slope) if errors is None else np.array(errors, float).reshape(slope.shape)
    return Pieces(first, stop, (first + stop - 1) / 2.0, level, slope, error)


def going(slopes: Any, lengths: Any, error: float = 0.0) -> Course:
    slope = np.array(slopes, dtype=float)
    return Course(slope, np.full(len(slope), error), np.array(lengths, dtype=float))


# -- the slope of a piece
def between(error: float, counts: list[int], joined: NDArray[np.bool_] | None = None) -> Course:
    """The course of three pieces at levels 0, 7 and 20 whose middle one says a slope of 5."""
    made = pieces(counts, [0.0, 7.0, 20.0], [0.0, 5.0, 0.0], [0.0, error, 0.0])
    total = sum(counts)
    given = blocks(total, sigma=1.0)
    return course(given if joined is None else replace(given, joined=joined), made)


def test_a_vague_piece_has_the_slope_of_its_neighbours() -> None:
    found = between(9.0, [4, 2, 4])
    # 20 in all over the six seconds between the outer middles
    assert found.slope.tolist() == pytest.approx([0.0, 20.0 / 6.0, 0.0])
    assert found.error[1] == pytest.approx(np.sqrt(1 / 4 + 1 / 4) / 6.0)
    assert found.length_s.tolist() == [3.0, 1.0, 3.0]


@pytest.mark.parametrize(
    ("error", "counts", "own"),
    [
        (0.11, [4, 2, 4], True),
        (0.12, [4, 2, 4], False),
        (9.0, [13, 2, 4], True),
        (9.0, [12, 2, 4], False),
    ],
)
def test_a_piece_that_says_enough_or_is_short_beside_others_keeps_its_slope(
    error: float, counts: list[int], own: bool
) -> None:
    # the neighbours' line is known to .1179, and neighbours of six times the length say nothing
    assert bool(between(error, counts).slope[1] == 5.0) is own


@pytest.mark.parametrize("gap", [3, 5])
def test_a_gap_beside_a_piece_leaves_it_its_slope(gap: int) -> None:
    joined = np.ones(9, dtype=bool)
    joined[gap] = False
    assert between(9.0, [4, 2, 4], joined).slope[1] == 5.0


# -- rest, and what is undriven
@pytest.mark.parametrize(
    ("count", "level", "change", "rests"),
    [
        (4, 2.0, 0.0, True),  # four deviations of a mean of four, of sigma 1
        (4, 2.1, 0.0, False),
        (4, -2.1, 0.0, False),
        (4, 0.0, 4.0, True),
        (4, 0.0, -4.1, False),
        (2, 0.0, 0.0, False),  # too few
        (3, 0.0, 0.0, True),
        (64, 0.7, 0.0, True),  # no faster than a speed of rest
        (64, 0.9, 0.0, False),
    ],
)
def test_rest(count: int, level: float, change: float, rests: bool) -> None:
    given = blocks(count, sigma=1.0, still=0.8)
    found = classify._resting(given, pieces([count], [level], [0.0]), going([change], [1.0]))
    assert found.tolist() == [rests]


DRIVE = Signal(np.zeros(1), 0.1, 0.1, 10.0)


@pytest.mark.parametrize(
    ("level", "slope", "undriven"),
    [
        (3.119, 0.0, True),  # .1 of a mean of 25, five times, and a five-hundredth of the largest
        (3.121, 0.0, False),
        (2.87, 0.0, False),
        (3.0, 0.23, True),
        (3.0, -0.25, False),
    ],
)
def test_a_drive_near_its_zero_is_none(level: float, slope: float, undriven: bool) -> None:
    made = pieces([25], [[9.0, level]], [[0.0, slope]])
    given = blocks(25, drive=DRIVE)
    found = classify._undriven(given, made, going([0.0], [1.0]), 3.0)
    assert found.tolist() == [undriven]
    assert classify._undriven(blocks(25), made, going([0.0], [1.0]), 3.0).tolist() == [False]


def zero(levels: Any, slopes: Any, speeds: Any, rest: list[int], counts: Any = (9, 9, 9)) -> float:
    """The drive's zero of three pieces a second long, by speed, its slope, and drive."""
    made = pieces(
        list(counts), np.column_stack([speeds, levels]), np.column_stack([slopes, np.zeros(3)])
    )
    given = blocks(sum(counts), drive=DRIVE)
    course = going(slopes, [1.0] * 3, error=2.0)
    return classify.drive_zero(given, made, course, np.array(rest, dtype=bool))


def test_the_drive_s_zero_is_its_level_at_rest_else_where_the_motor_slows() -> None:
    levels, speeds, slopes = [5.0, 1.0, 2.0], [50.0, 0.0, 40.0], [0.0, 0.0, -10.1]
    assert zero(levels, slopes, speeds, [0, 1, 0]) == 1.0
    assert zero(levels, slopes, speeds, [0, 0, 0]) == 2.0
    assert zero(levels, [0.0, 0.0, 10.1], [50.0, 0.0, -40.0], [0, 0, 0]) == 2.0
    for slope in (10.1, -9.9):  # it gains speed; it does not clearly lose any, or too little
        assert np.isnan(zero(levels, [0.0, 0.0, slope], speeds, [0, 0, 0]))
    assert np.isnan(zero(levels, slopes, speeds, [0, 1, 0], (9, 2, 2)))  # too short
    given = blocks(9, drive=DRIVE, drive_zero=-7.0)
    made = pieces([9], [[0.0, 1.0]], [[0.0, 0.0]])
    rest = np.ones(1, dtype=bool)
    assert classify.drive_zero(given, made, going([0.0], [1.0]), rest) == -7.0
    assert np.isnan(classify.drive_zero(blocks(9), made, going([0.0], [1.0]), rest))


# -- jumps between pieces
@pytest.mark.parametrize(
    ("before", "after", "names", "becomes"),
    [
        (10.0, 13.1, [S, S], A),
        (10.0, 12.9, [S, S], None),
        (-10.0, -13.1, [S, S], A),
        (13.1, 10.0, [S, R], B),
        (13.1, 10.0, [C, S], C),
        (10.0, 13.1, [A, S], None),  # whose change is seen
        (10.0, 13.1, [S, B], None),
    ],
)
def test_a_jump_faster_than_the_sampling_is_named(
    before: float, after: float, names: list[int], becomes: int | None
) -> None:
    speed = np.repeat([before, after], 5)
    given = np.repeat(names, 5)
    made = pieces([5, 5], [before, after], [0.0, 0.0])
    found = given.copy()
    jump = classify._jumps(blocks(10), made, speed, found)
    if becomes is None:
        assert not jump.any()
        assert found.tolist() == given.tolist()
    else:
        assert np.flatnonzero(jump).tolist() == [4, 5]
        assert found.tolist() == [*given[:4], becomes, becomes, *given[6:]]
    rough, broken = blocks(10, sigma=9.0), blocks(10)
    broken.joined[4] = False
    for one in (rough, broken):
        assert not classify._jumps(one, made, speed, given.copy()).any()


# -- creeps and coasts beside a brake
@pytest.mark.parametrize(("creep", "ends"), [(1, True), (2, False)])
@pytest.mark.parametrize("gap", [None, 19, 20])
def test_a_short_creep_between_a_brake_and_a_coast_ends_the_brake(
    creep: int, ends: bool, gap: int | None
) -> None:
    names = np.array([B] * 20 + [S] * creep + [C] * 9)  # a tenth of 20 is 2
    joined = np.ones(len(names) - 1, dtype=bool)
    if gap is not None:
        joined[gap if gap == 19 else 19 + creep] = False
    found = classify._released_without_pause(names.copy(), joined)
    assert found.tolist() == (
        [B] * (20 + creep) + [C] * 9 if ends and gap is None else names.tolist()
    )


@pytest.mark.parametrize(("first", "last"), [(A, C), (B, R), (C, C)])
def test_a_creep_elsewhere_stays(first: int, last: int) -> None:
    names = np.array([first] * 20 + [S] + [last] * 9)
    joined = np.ones(29, dtype=bool)
    assert classify._released_without_pause(names.copy(), joined).tolist() == names.tolist()


@pytest.mark.parametrize(("lost", "brakes"), [(2.4, True), (2.6, False), (-2.4, True)])
def test_a_little_coast_after_a_brake_belongs_to_it(lost: float, brakes: bool) -> None:
    names = np.array([S] * 5 + [B] * 10 + [C] * 5 + [R] * 5)
    speed = np.r_[
        np.full(5, 20.0),
        np.linspace(20.0, 10.0, 10),
        np.linspace(10.0, 10.0 - lost, 5),
        np.zeros(5),
    ]
    joined = np.ones(24, dtype=bool)
    found = classify._no_coast_after_brake(names.copy(), joined, speed)
    assert found[15:20].tolist() == [B if brakes else C] * 5
    assert np.delete(found, range(15, 20)).tolist() == np.delete(names, range(15, 20)).tolist()
    joined[14] = False
    assert classify._no_coast_after_brake(names.copy(), joined, speed).tolist() == names.tolist()


# -- what cannot be used
def of(speed: Any, ticks: Any = None, gaps: tuple[Gap, ...] = (), **channels: Any) -> Capture:
    made = {SPEED: Channel(SPEED, "rad/s", np.array(speed, dtype=float), raw_max=90.0)}
    for name, values in channels.items():
        made[name] = Channel(name, "", np.array(values, dtype=float), raw_min=-9.0, raw_max=9.0)
    moments = np.arange(len(speed)) * 10 if ticks is None else np.array(ticks)
    return Capture(moments, 1e4, made, gaps=gaps)


@pytest.mark.parametrize(
    ("steps", "gaps", "breaks"),
    [
        ([10] * 9, [], []),
        ([10, 10, 80, 10, 10, 81, 10], [], [6]),
        ([10, 0, 10, -5, 10], [], [2, 4]),
        ([10] * 5, [0, 3, 6], [3]),
        ([10, 10, 90, 10, 10], [3], [3]),
    ],
)
def test_breaks_are_declared_or_seen_in_the_clock(
    steps: list[int], gaps: list[int], breaks: list[int]
) -> None:
    ticks = np.r_[0, np.cumsum(steps)]
    capture = of(np.zeros(len(ticks)), ticks, tuple(Gap(index, 1, "") for index in gaps))
    assert split._breaks(capture).tolist() == breaks


def test_stretches_without_readings_or_at_an_end_are_rejected_with_the_reason() -> None:
    speed, volts = np.full(60, 5.0), np.full(60, 3.0)
    speed[20], speed[41], volts[40:42] = np.nan, 90.0, -9.0
    place = np.arange(60.0)
    place[55] = np.nan
    found = split.segment(of(speed, **{VOLTAGE: volts, POSITION: place}))
    rejected = [(s.start, s.stop, s.reason) for s in found if s.kind is SegmentKind.REJECTED]
    end = "is at an end of its converter's range"
    assert rejected == [
        (20, 21, "the speed has no reading here"),
        (40, 42, f"the terminal voltage {end}; the speed {end}"),
        (55, 56, "the position has no reading here"),
        (56, 60, "only 4 samples between two breaks, too few to judge the motion"),
    ]
    assert (found[0].start, found[-1].stop) == (0, 60)


@pytest.mark.parametrize(("count", "judged"), [(7, False), (8, True)])
def test_eight_samples_are_judged(count: int, judged: bool) -> None:
    (only,) = split.segment(of(np.full(count, 5.0)))
    assert (only.kind is not SegmentKind.REJECTED) is judged
    assert (only.start, only.stop, only.slice) == (0, count, slice(0, count))


def test_without_motion_or_samples_nothing_is_named() -> None:
    assert split.segment(of([])) == ()
    still = Capture(np.arange(9), 1e3, {CURRENT: Channel(CURRENT, "A", np.zeros(9))})
    why = "neither speed nor position was measured, so motion cannot be told from rest"
    assert split.segment(still) == (Segment(SegmentKind.REJECTED, 0, 9, why),)
