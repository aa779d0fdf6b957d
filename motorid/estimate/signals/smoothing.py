"""What the source of a part does beyond its line: a curve that is smooth after the head."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.step_transient import HEAD
from motorid.estimate.solver.dense_products import dot, square

Floats = NDArray[np.float64]

ODD_HEAD = 2.5  # variance of the few samples after a step, over the noise's: still called noise
BLOCKS, SLOW = 8, 28.0  # stretches of a part, and chi-square of their means: 1 in 2,000 by noise
ODD_SAMPLE = 3.5  # standard deviations from the line of one of them
NEAR = 32  # samples that tell where the source was just before them
WINDOWS = (64, 32, 16, 8, 4)  # half-widths in samples


def trend_of(
    left: Floats, noise: float, allowed: float, declared: float = 0.0
) -> tuple[Floats, int, bool]:
    """What the source does beyond its line, (n,), how many samples of the head depart from it, and
    whether that is free of noise. It is as read when no window leaves only noise behind: its head
    is then judged by the ``declared`` variance of a reading, as what comes and goes is no noise.
    """
    late = left[HEAD:]
    trend = np.zeros_like(left)
    quiet = True
    if square(late) / len(late) > allowed or _slow(late) > SLOW * noise:
        quiet = _wanders(late, allowed, trend[HEAD:])
        if not quiet:
            trend[HEAD:] = late
            noise = min(noise, declared or noise)
        trend[:HEAD] = _carried_back(late)
    odd = left[:HEAD] - trend[:HEAD]
    out = np.flatnonzero(np.abs(odd) > ODD_SAMPLE * np.sqrt(noise))
    head = int(out[-1]) + 1 if len(out) else 0
    if square(odd[head:]) > ODD_HEAD * noise * len(odd):
        head = HEAD
    return trend, head, quiet


def _slow(late: Floats) -> float:
    """Sum of squares of the means of BLOCKS stretches, times their length: noise alone has BLOCKS
    times its variance.
    """
    length = len(late) // BLOCKS
    sums: Floats = late[: BLOCKS * length].reshape(BLOCKS, length) @ np.ones(length)
    return square(sums) / max(length, 1)


def _wanders(late: Floats, allowed: float, trend: Floats) -> bool:
    """Writes the smoothest curve that leaves only noise; False when there is none."""
    for half in WINDOWS:
        if 4 * half > len(late):
            continue
        trend[:] = smoothed(late, half)
        rest = late - trend
        if square(rest) / len(rest) <= allowed:
            return True
    return False


def _carried_back(late: Floats) -> Floats:
    """The head (HEAD,) on the straight line through the samples that follow it."""
    near = late[:NEAR]
    place: Floats = np.arange(len(near), dtype=np.float64) - (len(near) - 1) / 2
    slope = dot(place, near) / square(place)
    return np.asarray(near.mean() + slope * (np.arange(-HEAD, 0) - (len(near) - 1) / 2))


def smoothed(values: Floats, half: int) -> Floats:
    """Mean over ``half`` samples on either side, fewer at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    place = np.arange(len(values))
    low, high = np.maximum(place - half, 0), np.minimum(place + half + 1, len(values))
    return np.asarray((total[high] - total[low]) / (high - low))
