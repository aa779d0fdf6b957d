"""What neighbours say of readings: their noise, by what they differ by, and what is usual there."""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HALF_BELOW = 0.6745  # standard deviations within which half of normal readings lie
LEVELS = 8  # of readings that are counts: a converter, or a channel that is held, has more
CLIP = 3.9  # standard deviations beyond which a difference is no noise; of no count a whole number


def neighbour_noise(values: Floats, order: int = 2) -> float:
    """Standard deviation of readings (n,), rounding and all; 0: too few, or most of them agree.

    By their differences of that ``order``, in which a polynomial of a lower one leaves nothing.
    """
    left = np.diff(values, order)
    return float(of_differences(left, order)) if len(left) else 0.0


def of_differences(left: Floats, order: int, step: float = 0.0) -> Floats:
    """Standard deviations (...,) of readings whose differences of that ``order`` are (..., n).

    Their median says which of them are jumps, and the mean square of the others is the noise: of
    readings in coarse steps the median itself is a whole number of steps, or none. A ``step`` of a
    converter is no jump.
    """
    sizes = np.abs(left)
    usual = np.maximum(np.median(sizes, axis=-1, keepdims=True) / HALF_BELOW, step)
    kept = sizes <= CLIP * usual
    squares = np.where(kept, sizes, 0.0) ** 2
    mean = squares.sum(axis=-1) / np.maximum(kept.sum(axis=-1), 1)
    return np.asarray(np.sqrt(mean / math.comb(2 * order, order)))


def counting_noise(values: Floats) -> float:
    """Standard deviation at most of readings (n,) that are whole counts of few levels, as of a
    speed by the counts since the reading before; 0 of others.

    Most neighbours agree there, and differences say nothing. One that is a count more or less by
    chance scatters by half of a count (Bernoulli).
    """
    jumps = np.abs(np.diff(values))
    jumps = jumps[jumps > 0.0]
    if not 0 < len(jumps) < len(values) / 2 or len(np.unique(values)) > LEVELS:
        return 0.0
    return float(np.median(jumps)) / 2.0


def running_median(values: Floats, side: int) -> Floats:
    """Of each value (n,) with so many on either side; the first and the last stand for more."""
    around = sliding_window_view(np.pad(values, side, mode="edge"), 2 * side + 1)
    return np.asarray(np.median(around, axis=1))
