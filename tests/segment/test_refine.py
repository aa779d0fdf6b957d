"""Where an edge is put, by signals made for it: blocks of ten samples each."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.segment.blocks import Blocks, Signal
from motorid.segment.classify import SHORT
from motorid.segment.pieces import Pieces
from motorid.segment.refine import WINDOW_BLOCKS, Edge, change_point, edge_sample
from motorid.segment.types import SegmentKind

EACH, COUNT = 10, 40
EDGE = 12  # its block


def blocks(speed: np.ndarray, drive: np.ndarray | None = None, each: int = EACH) -> Blocks:
    """Blocks over all samples, without a break."""
    start = np.arange(0, len(speed), each)
    of_blocks = Signal(speed[start], 0.0, 0.0, 1.0)
    return Blocks(
        start=start,
        stop=start + each,
        time_s=start * 1e-3,
        joined=np.ones(len(start), dtype=bool),
        speed=of_blocks,
        still=0.5,
        drive=None,
        drive_zero=None,
        speed_samples=speed,
        drive_samples=drive,
    )


def no_lines() -> Pieces:
    """What no edge of these tests asks for."""
    return Pieces(*(np.zeros(0) for _ in range(6)))  # type: ignore[arg-type]


def lines(meet_s: float, before: float, after: float) -> Pieces:
    """Two lines with these slopes that meet at 5 rad/s, one up to the edge's block, one from it."""
    first, stop = np.array([0, EDGE]), np.array([EDGE, COUNT])
    middle, slope = (EACH * (first + stop) - 1) / 2 * 1e-3, np.array([before, after])
    level = 5.0 + slope * (middle - meet_s)
    return Pieces(first, stop, middle, level[:, None], slope[:, None], np.zeros((2, 1)))


EDGE_AMID = Edge(before=0, block=EDGE, after=COUNT)
LAST_SEEN = EACH * (EDGE + WINDOW_BLOCKS) - 1  # the last sample of the window after the edge


@pytest.mark.parametrize("last", [EACH * EDGE - 3, EACH * EDGE, LAST_SEEN])
def test_rest_begins_after_the_last_sample_that_moves(last: int) -> None:
    speed = np.zeros(EACH * COUNT)
    speed[last] = 10.0
    edge = Edge(before=4, block=EDGE, after=COUNT)
    found = edge_sample(blocks(speed), no_lines(), edge, SegmentKind.COAST, SegmentKind.REST)
    assert found == last + 1


def test_motion_beyond_the_window_is_no_end_of_the_stretch_before() -> None:
    speed = np.zeros(EACH * COUNT)
    speed[LAST_SEEN + 1] = 10.0
    edge = Edge(before=4, block=EDGE, after=COUNT)
    found = edge_sample(blocks(speed), no_lines(), edge, SegmentKind.COAST, SegmentKind.REST)
    assert found == EACH * (EDGE - 4)  # nothing moves from half the stretch before the edge on


@pytest.mark.parametrize("length", [SHORT - 1, SHORT])
def test_a_stretch_of_single_samples_needs_a_few_of_them_to_be_refined(length: int) -> None:
    """A jump of the drive moves the edge, unless the stretch is as short as a misnamed one."""
    drive = np.zeros(COUNT)
    drive[EDGE + 1 :] = 1.0
    edge = Edge(before=EDGE - length, block=EDGE, after=EDGE + 10)
    made = blocks(np.ones(COUNT), drive, each=1)
    found = edge_sample(made, no_lines(), edge, SegmentKind.REST, SegmentKind.ACCELERATION)
    assert found == EDGE + (length >= SHORT)


@pytest.mark.parametrize("fading", [[0.6], [0.6, 0.3], [0.8, 0.5, 0.2]])
def test_a_drive_that_fades_has_left_after_its_first_and_arrived_after_its_last(
    fading: list[float],
) -> None:
    drive = np.array([1.0] * 20 + fading + [0.0] * 20)
    assert change_point(drive, after_jump=False) == 20
    assert change_point(drive, after_jump=True) == 20 + len(fading)


def test_a_last_reading_beside_the_level_does_not_hide_where_the_drive_arrived() -> None:
    drive = np.array([1.0] * 20 + [0.0] * 20 + [0.3])
    assert change_point(drive, after_jump=True) == 20


@pytest.mark.parametrize("meet_s", [0.117, 0.1205, 0.124])
def test_without_a_drive_the_edge_is_where_the_lines_of_the_speed_cross(meet_s: float) -> None:
    time = np.arange(EACH * COUNT) * 1e-3
    speed = np.where(time < meet_s, 5.0, 5.0 - 40.0 * (time - meet_s))
    made = blocks(speed)
    made = replace(made, time_s=made.time_s + (EACH - 1) / 2 * 1e-3)  # of the middle of each block
    found = edge_sample(
        made, lines(meet_s, 0.0, -40.0), EDGE_AMID, SegmentKind.STEADY, SegmentKind.BRAKE
    )
    assert abs(time[found] - meet_s) <= 1.001e-3


def test_lines_that_never_cross_leave_the_edge_at_its_block() -> None:
    found = edge_sample(
        blocks(np.full(EACH * COUNT, 5.0)), lines(0.12, 0.0, 0.0), EDGE_AMID,
        SegmentKind.STEADY, SegmentKind.BRAKE,
    )  # fmt: skip
    assert found == EACH * EDGE
