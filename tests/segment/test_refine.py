"""Where an edge is put, by signals made for it: blocks of ten samples each."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.segment.blocks import Blocks, Signal
from motorid.segment.classify import SHORT
from motorid.segment.pieces import Pieces
from motorid.segment.refine import WINDOW_BLOCKS, Edge, edge_sample
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
