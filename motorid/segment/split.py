"""Segments of a capture: what can be used is named, what cannot is rejected with a reason."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, VOLTAGE, Capture
from motorid.segment.blocks import Blocks, Ints, drive_channel, make_blocks, stretches
from motorid.segment.classify import KINDS, fit_pieces, name_blocks
from motorid.segment.pieces import Pieces
from motorid.segment.refine import Edge, edge_sample
from motorid.segment.types import Segment, SegmentKind

SHORTEST = 8  # samples: a stretch below this says nothing about motion
TIME_JUMP = 8.0  # usual periods between two samples that make a gap, declared or not


def segment(capture: Capture) -> tuple[Segment, ...]:
    """Segments that cover the capture in order, without overlap; none for an empty capture.

    Gaps in time always end a segment. Stretches with missing or saturated readings, or too short
    to judge, come back as REJECTED with the reason.
    """
    n = len(capture)
    if not n:
        return ()
    if capture.get(SPEED) is None and capture.get(POSITION) is None:
        why = "neither speed nor position was measured, so motion cannot be told from rest"
        return (Segment(SegmentKind.REJECTED, 0, n, why),)
    refused = _refused_samples(capture)
    usable = np.ones(n, dtype=bool)
    for mask, _ in refused:
        usable &= ~mask
    runs = stretches(usable, _breaks(capture))
    long_enough = [run for run in runs if run[1] - run[0] >= SHORTEST]
    found = _name(capture, long_enough) if long_enough else []
    short = [_rejected(a, b, _too_short(b - a)) for a, b in runs if b - a < SHORTEST]
    bad = [_rejected(a, b, _why(refused, a, b)) for a, b in stretches(~usable, _breaks(capture))]
    return tuple(sorted(found + short + bad, key=lambda s: s.start))


def _rejected(start: int, stop: int, reason: str) -> Segment:
    return Segment(SegmentKind.REJECTED, start, stop, reason)


def _too_short(samples: int) -> str:
    return f"only {samples} samples between two breaks, too few to judge the motion"


def _breaks(capture: Capture) -> Ints:
    """Samples before which data are missing, by the capture's account or by its clock."""
    declared = [gap.index for gap in capture.gaps if 0 < gap.index < len(capture)]
    steps = np.diff(capture.ticks)
    usual = np.median(steps) if len(steps) else 0
    jumps = np.flatnonzero((steps > TIME_JUMP * usual) | (steps <= 0)) + 1
    return np.unique(np.concatenate((np.array(declared, dtype=np.int64), jumps)))


def _refused_samples(capture: Capture) -> list[tuple[NDArray[np.bool_], str]]:
    """What makes single samples unusable, with the words for it."""
    refused = []
    for name in (CURRENT, TORQUE, VOLTAGE, SPEED, POSITION):
        channel = capture.get(name)
        if channel is None:
            continue
        words = name.replace("_", " ")
        missing = ~np.isfinite(channel.values)
        refused.append((missing, f"the {words} has no reading here"))
        if name != POSITION:
            saturated = channel.saturated & ~missing
            refused.append((saturated, f"the {words} is at an end of its converter's range"))
    return refused


def _why(refused: list[tuple[NDArray[np.bool_], str]], start: int, stop: int) -> str:
    return "; ".join(words for mask, words in refused if mask[start:stop].any())


def _name(capture: Capture, runs: list[tuple[int, int]]) -> list[Segment]:
    blocks = make_blocks(capture, runs)
    pieces = fit_pieces(blocks)
    names = name_blocks(blocks, pieces)
    edges = np.flatnonzero((names[1:] != names[:-1]) | ~blocks.joined) + 1
    first = np.concatenate(([0], edges)).astype(np.int64)
    start = _edge_samples(blocks, pieces, first, names)
    stop = np.append(start[1:], blocks.stop[-1])
    broken = np.flatnonzero(~blocks.joined[edges - 1])
    stop[broken] = blocks.stop[edges[broken] - 1]
    kinds = names[first]
    return [
        Segment(KINDS[k], int(a), int(b), _remark(capture, blocks, KINDS[k], int(a), int(b)))
        for k, a, b in zip(kinds, start, stop, strict=True)
        if b > a
    ]


def _edge_samples(blocks: Blocks, pieces: Pieces, first: Ints, names: Ints) -> Ints:
    """First samples of the segments: moved to the turn where two meet, kept at a break."""
    start = blocks.start[first].copy()
    after = np.append(first[1:], len(names))
    for j in range(1, len(first)):
        if blocks.joined[first[j] - 1]:
            edge = Edge(int(first[j - 1]), int(first[j]), int(after[j]))
            before, here = KINDS[names[edge.block - 1]], KINDS[names[edge.block]]
            start[j] = max(edge_sample(blocks, pieces, edge, before, here), start[j - 1])
    return np.asarray(start)


def _remark(capture: Capture, blocks: Blocks, kind: SegmentKind, start: int, stop: int) -> str:
    """What a reader should know of a segment that is not rejected."""
    if kind is SegmentKind.BRAKE and drive_channel(capture) is None:
        return "no current was measured: this may be coasting"
    return ""
