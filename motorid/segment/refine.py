"""Puts the edges between named stretches on the sample where the signals turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motorid.segment.blocks import MAD_TO_SIGMA, Blocks, Floats
from motorid.segment.classify import SHORT
from motorid.segment.pieces import Pieces
from motorid.segment.types import SegmentKind

WINDOW_BLOCKS = 8
CLEAR_JUMP = 6.0  # standard deviations of a reading
DEPARTED = 4.0  # standard deviations of a reading: further than this from a level has left it
DEPARTED_SHARE = 0.02  # of the jump, likewise


@dataclass(frozen=True)
class Edge:
    """A segment begins at ``block``; the one before began at ``before``, the next at ``after``."""

    before: int
    block: int
    after: int


def edge_sample(
    blocks: Blocks, pieces: Pieces, edge: Edge, before: SegmentKind, here: SegmentKind
) -> int:
    """The sample at which ``here`` begins: where the drive jumps, motion ends, or speed bends.

    The begin of steady state and a reversal are no such events: they stay where they are.
    """
    back = min(WINDOW_BLOCKS, (edge.block - edge.before) // 2)
    on = min(WINDOW_BLOCKS, (edge.after - edge.block + 1) // 2)
    low, high = int(blocks.start[edge.block - back]), int(blocks.stop[edge.block + on - 1])
    reversal = (before, here) == (SegmentKind.BRAKE, SegmentKind.ACCELERATION)
    single = blocks.stop[edge.block] - blocks.start[edge.block] == 1
    brief = single and min(edge.block - edge.before, edge.after - edge.block) < SHORT
    if here is SegmentKind.STEADY or reversal or brief:
        return int(blocks.start[edge.block])
    if here is SegmentKind.REST:
        return _last_motion(blocks, low, int(blocks.stop[edge.after - 1]), edge)
    if blocks.drive_samples is not None:
        coasting = here is SegmentKind.COAST
        jump = change_point(blocks.drive_samples[low:high], after_jump=coasting)
        if jump is not None:
            return low + jump
    return _bend(blocks, pieces, edge.block, low, high)


def _last_motion(blocks: Blocks, low: int, high: int, edge: Edge) -> int:
    """The sample after the last one near the edge that still moves."""
    still = blocks.speed_samples[int(blocks.start[edge.block]) : high]
    noise = MAD_TO_SIGMA * float(np.median(np.abs(still - np.median(still))))
    near = int(blocks.stop[min(edge.block + WINDOW_BLOCKS, edge.after) - 1])
    floor = max(CLEAR_JUMP * noise, blocks.still)
    moving = np.flatnonzero(np.abs(blocks.speed_samples[low:near]) > floor)
    return low + int(moving[-1]) + 1 if len(moving) else low


def change_point(values: Floats, after_jump: bool) -> int | None:
    """Where ``values`` leave their first level, or reach their last; None without a clear jump."""
    n = len(values)
    if n < 4:
        return None
    left = np.arange(1, n)
    total = np.cumsum(values - values[0])
    between = (total[:-1] - left * total[-1] / n) ** 2 * n / (left * (n - left))
    split = int(np.argmax(between)) + 1
    before, after = values[:split], values[split:]
    noise = MAD_TO_SIGMA * float(np.median(np.abs(np.diff(values)))) / np.sqrt(2)
    jump = abs(float(np.median(after) - np.median(before)))
    if jump <= CLEAR_JUMP * noise / np.sqrt(min(split, n - split)) or split in (1, n - 1):
        return None
    if jump <= 2 * DEPARTED * noise:
        return split
    level = float(np.median(after if after_jump else before))
    near = np.abs(values - level) <= max(DEPARTED * noise, DEPARTED_SHARE * jump)
    if after_jump:
        far = np.flatnonzero(~near)
        return int(far[-1]) + 1 if len(far) and far[-1] + 1 < n else split
    close = np.flatnonzero(near[:split])
    return int(close[-1]) + 1 if len(close) else split


def _bend(blocks: Blocks, pieces: Pieces, edge: int, low: int, high: int) -> int:
    """Where the speed's lines before and after the edge cross, if that is nearby."""
    right = int(np.searchsorted(pieces.first, edge, side="right")) - 1
    if pieces.first[right] != edge or right == 0:
        return int(blocks.start[edge])
    left = right - 1
    slope = pieces.slope[[left, right], 0]
    if slope[0] == slope[1]:
        return int(blocks.start[edge])
    base = pieces.level[[left, right], 0] - slope * pieces.middle[[left, right]]
    crossing = float((base[0] - base[1]) / (slope[1] - slope[0]))
    begin, end = blocks.time_s[edge - 1], blocks.time_s[edge]
    share = (crossing - begin) / (end - begin)
    middle = 0.5 * (blocks.start[edge - 1] + blocks.stop[edge - 1])
    sample = middle + share * (blocks.start[edge] - blocks.start[edge - 1])
    return int(np.clip(round(sample), low, high))
