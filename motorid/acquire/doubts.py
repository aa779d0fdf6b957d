"""What a run shows of sensors that failed in its middle, by itself and without a motor's model.

Limits are the board's to keep, and whether figures make sense is the fit's to judge; here is only
what no motor and no noise can do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, Capture, Channel
from motorid.program import Step, StepKind

CHANCE = 1e-6  # of a healthy run to be doubted for its noise
LEAST_NOISE = 0.25  # counts; below, a steady reading may well repeat itself for ever
SHORTEST = 20  # samples
WINDOW_S = 0.02
MOVING = 20  # counts in a window, after which a rotor does not stop at once
ABRUPT = 0.15  # of that way in its last quarter: 1/16 at a steady deceleration, 1/4 at a jam
DRIVES = (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)


def doubts(capture: Capture) -> list[str]:
    """A sentence for each sensor that surely failed in mid-run."""
    if len(capture) < 2:
        return []
    return [*_stuck(capture), *_still(capture)]


# ---------------------------------------------------------------- converters


def _stuck(capture: Capture) -> Iterator[str]:
    """Channels whose noise is gone for longer than chance allows."""
    for name, channel in capture.channels.items():
        longest = _longest_chance(channel, len(capture))
        if name == POSITION or longest is None:
            continue
        begin, length = _longest_repeat(channel)
        if length > longest:
            yield (
                f"{name} reads {channel.values[begin]:.4g} {channel.unit} without a change from "
                f"{capture.time_s[begin]:.3f} s on for {length} samples, though it has noise: its "
                "converter or its wire failed"
            )


def _longest_chance(channel: Channel, samples: int) -> int | None:
    """How often healthy noise repeats a reading, at most; None where that is not known."""
    noise = channel.noise / channel.resolution if channel.resolution else 0.0
    if noise < LEAST_NOISE:
        return None
    same = math.erf(0.5 / (noise * math.sqrt(2)))  # the likeliest count's probability
    return max(SHORTEST, math.ceil(math.log(CHANCE / samples) / math.log(same)))


def _longest_repeat(channel: Channel) -> tuple[int, int]:
    """Index and length of the longest stretch of one reading; the converter's ends do not count."""
    raw = np.asarray(channel.raw)
    begins = np.flatnonzero(np.r_[True, np.diff(raw) != 0])
    lengths = np.diff(np.r_[begins, len(raw)])
    lengths = np.where(channel.saturated[begins], 0, lengths)
    index = int(np.argmax(lengths))
    return int(begins[index]), int(lengths[index])


# ---------------------------------------------------------------- encoder


def _still(capture: Capture) -> Iterator[str]:
    """The first drive in which a count stops that moved, or does not begin where it had before."""
    channel = capture.get(POSITION)
    if channel is None:
        return
    counts = np.asarray(channel.raw, dtype=np.int64)
    window = max(5, round(WINDOW_S / capture.period_s))
    moved: dict[StepKind, float] = {}  # the least level that turned the motor
    for step, stretch in _drives(capture):
        part = counts[stretch]
        stop = _stops(part, window)
        turns = abs(int(part[-1] - part[0])) >= MOVING if len(part) else False
        if stop is None and not turns and len(part) > 2 * window:
            should = abs(step.level) >= moved.get(step.kind, math.inf)
            stop = 0 if should and np.ptp(part) <= 1 else None
        if stop is not None:
            yield (
                f"the encoder stands still from {capture.time_s[stretch.start + stop]:.3f} s on "
                "while the bridge drives: the rotor jammed, or the encoder failed"
            )
            return
        if turns:
            moved[step.kind] = min(abs(step.level), moved.get(step.kind, math.inf))


def _drives(capture: Capture) -> Iterator[tuple[Step, slice]]:
    """Drive steps with the samples in them."""
    if capture.program is None:
        return
    ends = [*(phase.tick for phase in capture.phases), int(capture.ticks[-1]) + 1]
    for phase, (begin, end) in zip(capture.phases, pairwise(ends), strict=True):
        step = capture.program.steps[phase.index] if _knows(capture, phase.index) else None
        if step is not None and step.kind in DRIVES and step.level:
            first, last = np.searchsorted(capture.ticks, (begin, end))
            yield step, slice(int(first), int(last))


def _knows(capture: Capture, index: int) -> bool:
    return capture.program is not None and index < len(capture.program.steps)


def _stops(counts: NDArray[np.int64], window: int) -> int | None:
    """Where a count that moved stands still, at once and to the end of the stretch, for windows."""
    changes = np.flatnonzero(np.diff(counts))
    if not len(changes):
        return None
    last = int(changes[-1]) + 1
    before, lately = counts[max(0, last - window)], counts[max(0, last - window // 4)]
    way, end = abs(int(counts[last] - before)), abs(int(counts[last] - lately))
    abrupt = way >= MOVING and end >= ABRUPT * way
    return last if abrupt and len(counts) - last > 2 * window else None
