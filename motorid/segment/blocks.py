"""A capture as blocks of samples: mean time, speed and drive of each, and how noisy those are.

The speed of a block is that of the speed channel, or the slope of the position. Blocks are as
short as the noise allows: they grow until the noise of a block's speed is a small part of the
speeds in the capture. A block never crosses a gap or a missing reading.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, TORQUE, Capture, Channel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MAX_BLOCKS = 8192
MIN_BLOCKS = 96
NOISE_GOAL = 0.02  # of the largest speed: a block's noise that needs no longer block
REST_SPEED = 0.005  # of the largest speed: as good as rest
NOISE_FLOOR = 1e-3  # of the largest value: differences below this do not matter here
MAD_TO_SIGMA = 1.4826
CHUNKS = 32  # of a capture, each with its own noise
CHUNK_BLOCKS = 64  # at least, in such a chunk


@dataclass(frozen=True)
class Signal:
    """One quantity over the blocks: means (k,), their standard deviation, their largest size.

    ``noisiest`` is the standard deviation where it is largest: ripple comes only while driving.
    """

    mean: Floats
    sigma: float
    noisiest: float
    scale: float


@dataclass(frozen=True)
class Blocks:
    """``start`` and ``stop`` are sample indices (k,); ``joined[j]``: no break after block j."""

    start: Ints
    stop: Ints
    time_s: Floats
    joined: NDArray[np.bool_]
    speed: Signal
    still: float  # a speed up to this is rest
    drive: Signal | None
    drive_zero: float | None  # where it is known: a commanded torque has no offset
    speed_samples: Floats  # of each sample of the capture
    drive_samples: Floats | None  # likewise


def drive_channel(capture: Capture) -> Channel | None:
    """What drives the shaft, as measured: the current, or the torque that the drive commands."""
    return capture.get(CURRENT) or capture.get(TORQUE)


def stretches(usable: NDArray[np.bool_], breaks: Ints) -> list[tuple[int, int]]:
    """Runs of usable samples between breaks, as (start, stop)."""
    n = len(usable)
    cut = np.zeros(n + 1, dtype=bool)
    cut[[0, n]] = True
    cut[breaks] = True
    cut[1:n] |= usable[1:] != usable[:-1]
    edges = np.flatnonzero(cut)
    return [(int(a), int(b)) for a, b in pairwise(edges) if usable[a]]


def make_blocks(capture: Capture, runs: list[tuple[int, int]]) -> Blocks:
    """Blocks over ``runs``, long enough for the noise of this capture's motion.

    Needs a speed or a position channel without a missing reading in the runs.
    """
    n = sum(stop - start for start, stop in runs)
    speeds, floor_at_one, averages_as = _sample_speeds(capture, runs)
    size = max(1, -(-n // MAX_BLOCKS))
    largest = max(size, n // MIN_BLOCKS)
    while True:
        edges = _edges(runs, size)
        speed = _signal(speeds, edges, floor_at_one / size**averages_as)
        excess = speed.sigma / (NOISE_GOAL * speed.scale) if speed.scale else 0.0
        if excess <= 1 or size >= largest:
            return _assemble(capture, edges, speed, speeds)
        size = min(largest, max(size + 1, int(size * min(excess, 4.0))))


def _sample_speeds(capture: Capture, runs: list[tuple[int, int]]) -> tuple[Floats, float, float]:
    """Speed at each sample, the quantisation noise of one, and the power by which that averages."""
    channel = capture.get(SPEED)
    if channel is not None:
        return channel.values, _quantum(channel) / np.sqrt(12), 0.0
    channel = capture.channels[POSITION]
    slope = np.zeros(len(capture))
    slope[:-1] = np.diff(channel.values) / np.diff(capture.time_s)
    last = np.array([stop for _, stop in runs]) - 1
    slope[last] = slope[np.maximum(last - 1, 0)]  # no next sample: the run goes on as it was
    return slope, channel.resolution / np.sqrt(6) / capture.period_s, 1.0


def _quantum(channel: Channel) -> float:
    """The channel's step: as declared, or the least by which its readings change."""
    steps = np.abs(np.diff(channel.values))
    steps = steps[np.isfinite(steps) & (steps > 0)]
    seen = float(np.percentile(steps, 5)) if len(steps) else 0.0
    return max(channel.resolution, seen)


def _edges(runs: list[tuple[int, int]], size: int) -> tuple[Ints, Ints, NDArray[np.bool_]]:
    """Starts and stops of blocks of ``size`` samples, and whether each is joined to the next."""
    starts, stops, joined = [], [], []
    for start, stop in runs:
        first = np.arange(start, max(stop - size // 2, start + 1), size)
        starts.append(first)
        stops.append(np.append(first[1:], stop))
        joined.append(np.arange(len(first)) < len(first) - 1)
    return np.concatenate(starts), np.concatenate(stops), np.concatenate(joined)[:-1]


def _means(values: Floats, start: Ints, stop: Ints) -> Floats:
    total = np.concatenate(([0.0], np.cumsum(np.where(np.isfinite(values), values, 0.0))))
    return np.asarray((total[stop] - total[start]) / (stop - start))


def _signal(values: Floats, edges: tuple[Ints, Ints, NDArray[np.bool_]], floor: float) -> Signal:
    mean = _means(values, edges[0], edges[1])
    scale = float(np.percentile(np.abs(mean), 99.5))
    sigma = max(_noise(mean, 1), floor, NOISE_FLOOR * scale)
    if len(mean) > 2:
        mean = _without_spikes(mean, edges[2], sigma)
    return Signal(mean, sigma, max(_noise(mean, CHUNKS), sigma), scale)


def _without_spikes(mean: Floats, joined: NDArray[np.bool_], sigma: float) -> Floats:
    """Single blocks far from both neighbours, which no shaft can do, take the middle value."""
    left, middle, right = mean[:-2], mean[1:-1], mean[2:]
    median = np.maximum(np.minimum(left, right), np.minimum(np.maximum(left, right), middle))
    far = np.abs(middle - median) > 8 * sigma
    back = np.abs(right - left) < 0.25 * np.abs(middle - median)
    cleaned = mean.copy()
    cleaned[1:-1] = np.where(far & back & joined[:-1] & joined[1:], median, middle)
    return cleaned


def _noise(mean: Floats, chunks: int) -> float:
    """Standard deviation of a block; that of the noisiest chunk where there are several.

    From second differences, which are blind to any straight course, by their median, which is
    blind to a few jumps.
    """
    largest = 0.0
    for lag in (1, 4):
        second = np.abs(mean[2 * lag :] - 2 * mean[lag:-lag] + mean[: -2 * lag])
        if len(second) > 2 * lag:
            parts = np.array_split(second, max(min(chunks, len(second) // CHUNK_BLOCKS), 1))
            largest = max(largest, *(float(np.median(part)) for part in parts))
    return MAD_TO_SIGMA * largest / float(np.sqrt(6))


def _assemble(
    capture: Capture,
    edges: tuple[Ints, Ints, NDArray[np.bool_]],
    speed: Signal,
    speeds: Floats,
) -> Blocks:
    start, stop, joined = edges
    motion, channel = capture.get(SPEED), drive_channel(capture)
    readings = drive = zero = None
    if channel is not None:
        centre = float(np.median(channel.values[np.isfinite(channel.values)]))
        readings = channel.values - centre  # an offset must not count as size
        drive = _signal(readings, edges, channel.resolution / np.sqrt(12))
        zero = -centre if channel.name == TORQUE else None
        drive = None if np.ptp(drive.mean) <= 4 * drive.sigma else drive
    return Blocks(
        start=start,
        stop=stop,
        time_s=_means(capture.time_s, start, stop),
        joined=joined,
        speed=speed,
        still=max(REST_SPEED * speed.scale, motion.resolution if motion else 0.0),
        drive=drive,
        drive_zero=zero,
        speed_samples=speeds,
        drive_samples=readings if drive is not None else None,
    )
