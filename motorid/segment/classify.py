"""Names the blocks: what the shaft does in each, from its straight pieces of speed and drive."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.segment.blocks import Blocks, Floats, Ints, Signal
from motorid.segment.pieces import Pieces, straight_pieces
from motorid.segment.types import SegmentKind

KINDS = tuple(SegmentKind)
REST, STEADY, COAST = (KINDS.index(SegmentKind(k)) for k in ("rest", "steady", "coast"))
ACCELERATION, BRAKE = (KINDS.index(SegmentKind(k)) for k in ("acceleration", "brake"))

PENALTY = 30.0  # chi-square per signal that one more piece must save
SIGNIFICANT = 5.0  # standard errors
REVERSAL = 0.4  # of its change: a piece whose level is less than this goes through zero
JUMP = 6.0  # standard deviations of a block
COASTED = 0.1  # of the largest speed, lost at constant drive: that drive may be none
CHANGE = 0.03  # of the largest speed: smaller changes are wander, not a transient
PEAK = 0.05  # of the steepest slope in the capture: gentler runs are wander
VAGUE = 0.02  # of the steepest slope: a standard error above this says too little
ALIKE = 6  # times as long as a piece: longer neighbours say nothing of its slope
LARGE_CHANGE = 0.3  # of the largest speed: a transient however gentle
SETTLED = 0.01  # of the change of a transient: what may remain when steady state begins
TAIL = 0.25  # of a brake's change: less speed lost without current after it is its tail
PAUSE = 0.1  # of a brake's length: a shorter steady creep before a coast belongs to it
GENTLE = 0.05  # of a transient's steepest slope: gentler for LINGER time constants is steady
LINGER = 2.0  # time constants, each the change of the transient over its steepest slope
DRIVE_SETTLED = 0.05  # of the final drive: what more or less of it may remain in steady state
DRIVE_LEAVES = 0.25  # of a steady stretch at least, or the drive is not waited for
SHORT = 3  # blocks: a shorter run of one kind belongs to its neighbours
SHORT_IF_VAGUE = 12  # blocks, for a run whose slope says too little


def fit_pieces(blocks: Blocks) -> Pieces:
    """Straight pieces of the speed, and of the drive where there is one."""
    signals = [blocks.speed] + ([blocks.drive] if blocks.drive else [])
    values = np.column_stack([s.mean for s in signals])
    levels = [blocks.speed.sigma] + ([blocks.drive.noisiest] if blocks.drive else [])
    sigma = np.maximum(levels, 1e-300)
    return straight_pieces(blocks.time_s, values, sigma, blocks.joined, PENALTY * len(signals))


@dataclass(frozen=True)
class Course:
    """How the speed goes on each piece (p,): slope, its standard error, duration."""

    slope: Floats
    error: Floats
    length_s: Floats


def course(blocks: Blocks, pieces: Pieces) -> Course:
    """The slope of each piece's own line, or between its neighbours where its own says too little.

    A short piece of a steep run has hardly a slope of its own; its neighbours' levels tell it.
    """
    slope, error = pieces.slope[:, 0].copy(), pieces.slope_error[:, 0].copy()
    length = blocks.time_s[pieces.stop - 1] - blocks.time_s[pieces.first]
    if len(slope) > 2:
        span = pieces.middle[2:] - pieces.middle[:-2]
        count = pieces.stop - pieces.first
        across = np.diff(pieces.level[:, 0])
        across = (across[1:] + across[:-1]) / span
        across_error = blocks.speed.sigma * np.sqrt(1 / count[2:] + 1 / count[:-2]) / span
        linked = blocks.joined[pieces.first[1:] - 1]
        steepest = np.max(np.abs(across))
        vague = error[1:-1] > np.maximum(across_error, VAGUE * steepest)
        alike = np.maximum(count[2:], count[:-2]) <= ALIKE * count[1:-1]
        better = linked[1:] & linked[:-1] & vague & alike
        slope[1:-1] = np.where(better, across, slope[1:-1])
        error[1:-1] = np.where(better, across_error, error[1:-1])
    return Course(slope, error, np.asarray(length))


def name_blocks(blocks: Blocks, pieces: Pieces) -> Ints:
    """The index into KINDS of each block, shape (k,)."""
    piece = np.repeat(np.arange(len(pieces.first)), pieces.stop - pieces.first)
    speed, going = pieces.at(piece, blocks.time_s), course(blocks, pieces)
    rest = _resting(blocks, pieces, going)
    moves = _transient(blocks, going, rest)
    zero = drive_zero(blocks, pieces, going, rest)
    undriven = _undriven(blocks, pieces, going, zero)
    reverses = np.abs(pieces.level[:, 0]) < REVERSAL * np.abs(going.slope) * going.length_s
    side = np.where((reverses & ~undriven)[piece], speed, pieces.level[piece, 0])
    faster = going.slope[piece] * side >= 0
    names = np.full(len(piece), STEADY)
    names[moves[piece]] = np.where(faster, ACCELERATION, BRAKE)[moves[piece]]
    gains = np.abs(going.slope * going.length_s) > CHANGE * blocks.speed.scale
    names[undriven[piece] & ~(gains[piece] & (names == ACCELERATION))] = COAST
    names[rest[piece]] = REST
    jump = _jumps(blocks, pieces, speed, names)
    fitted = [speed, *(pieces.at(piece, blocks.time_s, 1) for _ in range(blocks.drive is not None))]
    names = _settle(blocks, names, fitted, zero, jump)
    vague = going.error > VAGUE * np.max(np.abs(going.slope))
    names = _absorb_short(names, blocks.joined, jump, vague[piece])
    names = _stop_without_pause(names, blocks.joined)
    names = _released_without_pause(names, blocks.joined)
    return _no_coast_after_brake(names, blocks.joined, speed)


def _resting(blocks: Blocks, pieces: Pieces, going: Course) -> NDArray[np.bool_]:
    """Pieces without motion: no faster than the noise, or than a small part of the largest."""
    count = pieces.stop - pieces.first
    still = np.maximum(blocks.still, 4 * blocks.speed.sigma / np.sqrt(count))
    change = np.abs(going.slope) * going.length_s
    slow = (np.abs(pieces.level[:, 0]) <= still) & (change <= 2 * still)
    return np.asarray(slow & (count >= SHORT))


def _transient(blocks: Blocks, going: Course, rest: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pieces on which the speed changes by more than noise and wander."""
    slope, scale = going.slope, blocks.speed.scale
    change = slope * going.length_s
    clear = (np.abs(slope) > SIGNIFICANT * going.error) & ~rest
    large = clear & (np.abs(change) > CHANGE * scale)
    steepest = np.max(np.abs(slope[large]), initial=0.0)
    clear |= (np.abs(slope) > np.maximum(PEAK * steepest, 2 * going.error)) & ~rest
    sign = np.where(clear, np.sign(slope), 0.0)
    run = np.cumsum(np.concatenate(([0], sign[1:] != sign[:-1])))
    run_change = np.abs(np.bincount(run, change))[run]
    run_peak = np.zeros(run[-1] + 1)
    np.maximum.at(run_peak, run, np.abs(slope))
    peak = run_peak[run]
    steep = (peak > PEAK * steepest) | (run_change > LARGE_CHANGE * scale)
    lingers = going.length_s * peak > LINGER * run_change  # for that many time constants
    alive = np.abs(slope) > np.where(lingers, GENTLE, SETTLED) * peak
    return np.asarray(clear & steep & alive & (run_change > CHANGE * scale))


def _jumps(blocks: Blocks, pieces: Pieces, speed: Floats, names: Ints) -> NDArray[np.bool_]:
    """Marks, in place, the blocks about a jump between pieces: a change faster than the sampling.

    Returns which blocks those are.
    """
    jump = np.zeros(len(names), dtype=bool)
    after = pieces.first[1:]
    step = speed[after] - speed[after - 1]
    floor = max(CHANGE * blocks.speed.scale, JUMP * blocks.speed.sigma)
    calm = (REST, STEADY, COAST)
    unseen = np.isin(names[after], calm) & np.isin(names[after - 1], calm)
    for j in after[(np.abs(step) > floor) & blocks.joined[after - 1] & unseen]:
        faster = abs(speed[j]) > abs(speed[j - 1])
        slower = COAST if names[j - 1] == COAST else BRAKE
        names[j - 1 : j + 1] = ACCELERATION if faster else slower
        jump[j - 1 : j + 1] = True
    return jump


def _undriven(blocks: Blocks, pieces: Pieces, going: Course, zero: float) -> NDArray[np.bool_]:
    """Pieces on which no current flows: the drive stays at its ``zero``."""
    drive = blocks.drive
    if drive is None:
        return np.zeros(len(pieces.first), dtype=bool)
    count = pieces.stop - pieces.first
    near = SIGNIFICANT * drive.sigma / np.sqrt(count) + 2e-3 * drive.scale
    change = np.abs(pieces.slope[:, 1]) * going.length_s
    return np.asarray((np.abs(pieces.level[:, 1] - zero) < near) & (change < 2 * near))


def drive_zero(blocks: Blocks, pieces: Pieces, going: Course, rest: NDArray[np.bool_]) -> float:
    """The drive's reading when nothing is driven: its level at rest, else on a flat slowing piece.

    An offset of the sensor is thereby taken out. Of several such levels (a stalled motor also
    rests) the one that lasts longest counts; NaN where there is none, so that nothing is near it.
    """
    if blocks.drive is None:
        return float("nan")
    if blocks.drive_zero is not None:
        return blocks.drive_zero
    count = pieces.stop - pieces.first
    flat = np.abs(pieces.slope[:, 1]) * going.length_s < 4 * blocks.drive.sigma
    slowing = going.slope * np.sign(pieces.level[:, 0]) < 0
    clear = np.abs(going.slope) > SIGNIFICANT * going.error
    long = flat & (count >= SHORT)
    fades = np.abs(going.slope) * going.length_s > COASTED * blocks.speed.scale
    for candidates in (rest & long, slowing & clear & fades & long):
        if candidates.any():
            return _commonest(pieces.level[candidates, 1], count[candidates], blocks.drive.sigma)
    return float("nan")


def _commonest(levels: Floats, weights: Ints, width: float) -> float:
    near = np.abs(levels[:, None] - levels[None, :]) < 4 * width
    heaviest = int(np.argmax(near @ weights))
    return float(np.average(levels[near[heaviest]], weights=weights[near[heaviest]]))


def _settle(
    blocks: Blocks, names: Ints, fitted: list[Floats], zero: float, jump: NDArray[np.bool_]
) -> Ints:
    """Moves the end of each transient to where little of its change remains.

    A hundredth of the speed's change, and a twentieth of the final drive where that leaves enough
    of the stretch. What settles at no speed is rest, though the piece before it began with some.
    """
    edge = np.flatnonzero(names[1:] != names[:-1]) + 1
    for j in edge[(names[edge] == STEADY) & np.isin(names[edge - 1], (ACCELERATION, BRAKE))]:
        begin = int(edge[edge < j][-1]) if (edge < j).any() else 0
        later = edge[edge > j]
        end = int(later[0]) if len(later) else len(names)
        calm = slice(j + (end - j) // 2, end)
        speed = fitted[0]
        remaining = np.abs(speed[begin:end] - np.mean(speed[calm]))
        near = remaining <= max(SETTLED * remaining[0], 0.25 * blocks.speed.sigma)
        near &= ~np.logical_or.accumulate(jump[begin:end][::-1])[::-1]
        first = begin + int(np.argmax(near)) if near.any() else int(j)
        names[begin:first] = names[j - 1]
        last = blocks.speed.mean[calm]
        still = max(blocks.still, 4 * blocks.speed.sigma / np.sqrt(len(last)))
        names[first:end] = REST if abs(np.mean(last)) <= still else STEADY
        if blocks.drive and names[first] == STEADY:
            final = _drive_settled(blocks.drive, fitted[1] - zero, first, end)
            names[first:final] = names[j - 1]
    return names


def _drive_settled(drive: Signal, above_zero: Floats, first: int, end: int) -> int:
    """The block from ``first`` at which the drive is near its final level, if that is early."""
    final = float(np.mean(above_zero[end - max((end - first) // 4, 1) : end]))
    near = np.abs(above_zero[first:end] - final) <= max(DRIVE_SETTLED * abs(final), drive.sigma / 2)
    late = first + int(np.argmax(near))
    return late if near.any() and late - first <= (1 - DRIVE_LEAVES) * (end - first) else first


def _absorb_short(
    names: Ints, joined: NDArray[np.bool_], jump: NDArray[np.bool_], vague: NDArray[np.bool_]
) -> Ints:
    """Gives runs too short to be judged to their neighbours, unless they are a jump.

    So short a steady state or coast is the foot or the tail of a transient.
    """
    edges = np.concatenate(([0], np.flatnonzero((names[1:] != names[:-1]) | ~joined) + 1))
    for a, b in pairwise(edges[1:]):
        inside = joined[a - 1] and joined[b - 1] and not jump[a:b].any()
        undecided = names[a] in (STEADY, COAST)
        short = b - a < SHORT or (b - a < SHORT_IF_VAGUE and undecided and vague[a:b].all())
        if short and inside and (undecided or names[a - 1] == names[b]):
            names[a:b] = names[b] if names[b] != REST else names[a - 1]
    return names


def _stop_without_pause(names: Ints, joined: NDArray[np.bool_]) -> Ints:
    """A steady creep between slowing down and rest is the end of the slowing down."""
    edge = np.flatnonzero((names[1:] != names[:-1]) | ~joined) + 1
    for a, b in pairwise(edge):
        slowing = names[a - 1] in (BRAKE, COAST) and joined[a - 1]
        if slowing and names[a] == STEADY and names[b] == REST and joined[b - 1]:
            names[a:b] = names[a - 1]
    return names


def _released_without_pause(names: Ints, joined: NDArray[np.bool_]) -> Ints:
    """A short steady creep between a brake and a coast is the end of the brake."""
    edge = np.concatenate(([0], np.flatnonzero((names[1:] != names[:-1]) | ~joined) + 1))
    for before, a, b in zip(edge[:-2], edge[1:-1], edge[2:], strict=True):
        slowing = names[a - 1] == BRAKE and names[b] == COAST and joined[a - 1] and joined[b - 1]
        if slowing and names[a] == STEADY and b - a < PAUSE * (a - before):
            names[a:b] = BRAKE
    return names


def _no_coast_after_brake(names: Ints, joined: NDArray[np.bool_], speed: Floats) -> Ints:
    """A little undriven motion after a brake is its current passing zero or dying out."""
    edge = np.concatenate(([0], np.flatnonzero((names[1:] != names[:-1]) | ~joined) + 1))
    stop = np.append(edge[1:], len(names))
    for before, a, b in zip(edge[:-1], edge[1:], stop[1:], strict=True):
        braked = names[a - 1] == BRAKE and joined[a - 1]
        lost, lost_before = abs(speed[a] - speed[b - 1]), abs(speed[before] - speed[a - 1])
        if braked and names[a] == COAST and lost < TAIL * lost_before:
            names[a:b] = BRAKE
    return names
