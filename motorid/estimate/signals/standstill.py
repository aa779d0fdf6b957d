"""Whether a motor stood still: as a run began, and in parts in which it was driven all the same.

Breakaway and cogging hold a rotor against more torque than T0, the level of a motion. A model that
knows T0 alone would let it creep: where the encoder shows no motion, it is told to stand.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.signals.measurements import motion
from motorid.estimate.signals.time_grid import Part, Timeline

Floats = NDArray[np.float64]

STIR = 1.5  # steps of a channel, such as counts, by which the edge of one may flicker
FEWEST = 24  # readings that tell
HEAD = 8  # samples that show whether a record begins at rest
RISEN = 0.1  # of the largest current, between two readings: a voltage came on
COUNTS, LONGEST = 6.0, 16  # of an encoder that show a motion; times so many samples, at most


def with_standstill(capture: Capture, timeline: Timeline) -> Timeline:
    """With those parts marked in which the position stayed within a count from beginning to end."""
    channel = capture.get(POSITION)
    if channel is None or channel.resolution <= 0 or capture.program is None:
        return timeline
    place = timeline.spread(channel.values)

    def stands(part: Part) -> bool:
        here = place[part.slice]
        here = here[np.isfinite(here)]
        if part.open or not part.level or len(here) < FEWEST:
            return False
        return float(np.ptp(here)) <= STIR * channel.resolution

    return replace(timeline, parts=tuple(replace(p, still=stands(p)) for p in timeline.parts))


def starts_at_rest(capture: Capture, driven: NDArray[np.bool_]) -> bool:
    """The motor stands still, and carries no current, over the first few samples."""
    moving, current = motion(capture), capture.get(CURRENT)
    noise_of = _noise if capture.program is not None else _least_noise
    if moving is not None and moving.name == POSITION and _moves(moving):
        return False
    if moving is not None and moving.name == SPEED and not _is_near_zero(moving, noise_of):
        return False
    return not driven[0] or current is None or _is_near_zero(current, noise_of)


def unpowered(capture: Capture) -> bool:
    """A log's first few samples show neither a voltage nor a current: a motor that turned would
    show one of them, whatever is connected to it.
    """
    each = (capture.get(VOLTAGE), capture.get(CURRENT))
    return all(one is None or _is_near_zero(one, _least_noise) for one in each)


def switched_on(capture: Capture) -> bool:
    """The current rises from none as a log begins, and by much: as at a trigger on the step."""
    current = capture.get(CURRENT)
    if current is None or not np.isfinite(current.values[:2]).all() or len(current.values) < 2:
        return False
    first, risen = float(current.values[0]), float(np.diff(current.values[:2])[0])
    largest = float(np.nanmax(np.abs(current.values)))
    return abs(first) <= abs(risen) and first * risen >= 0.0 and abs(risen) >= RISEN * largest


def _moves(position: Channel) -> bool:
    head = _head(position)
    early, late = position.values[:head], position.values[head : 2 * head]
    late = late[: len(early)]
    early = early[: len(late)]
    if not (np.isfinite(np.diff(early)).any() and np.isfinite(late - early).any()):
        return False
    scatter = float(np.nanstd(np.diff(early)))
    return abs(float(np.nanmean(late - early))) > 2.0 * scatter + STIR * position.resolution


def _head(position: Channel) -> int:
    """``HEAD`` samples, or as many more as a fast motor takes for some counts of its encoder."""
    moved = np.abs(position.values[HEAD:] - position.values[:-HEAD])
    moved = moved[np.isfinite(moved)]
    if not len(moved) or position.resolution <= 0.0:
        return HEAD
    fast = max(float(np.percentile(moved, 98)), position.resolution / LONGEST)
    return HEAD * math.ceil(min(COUNTS * position.resolution / fast, LONGEST))


def _is_near_zero(channel: Channel, noise_of: Callable[[Floats], float]) -> bool:
    head, steps = channel.values[:HEAD], np.diff(channel.values[: 8 * HEAD])
    if not (np.isfinite(head).any() and np.isfinite(steps).any()):
        return False  # nothing was read that could show it
    return abs(float(np.nanmean(head))) <= 3.0 * noise_of(steps) + channel.resolution


def _noise(steps: Floats) -> float:
    """Standard deviation of what neighbours (n,) differ by."""
    return float(np.nanstd(steps))


def _least_noise(steps: Floats) -> float:
    """The same of the quietest few: a log of few readings a motion steps by the motion itself."""
    parts = np.array_split(steps, max(len(steps) // (HEAD - 1), 1))
    return min(_noise(part) for part in parts if np.isfinite(part).any())
