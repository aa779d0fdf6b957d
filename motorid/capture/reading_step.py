"""The step of which all readings of a column are multiples: of a converter, a counter, a file."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FEWEST = 8  # values
LEVELS = 4096  # no more distinct values than this may be rounded, and still be of one step
ROUGH, EXACT = 0.1, 1e-3  # of a step, by which none of few levels, or of many, misses its grid
FARTHER = (8.0, 64.0, 512.0, np.inf)  # steps between two levels, that tell the size of one
ROUNDED = 1e-9  # of the largest value: what arithmetic leaves of equal readings


def reading_step(values: Floats) -> float:
    """The step of which all finite values (n,) are multiples, or 0 where they look continuous.

    Levels that differ by rounding alone are one: a speed may be a difference of angles. Where most
    readings come back to none, as of an angle that goes on or of many bits, all must lie exactly.
    """
    values = values[np.isfinite(values)]
    largest = float(np.abs(values).max(initial=0.0))
    if len(values) < FEWEST or not largest > 0.0:
        return 0.0
    scale = math.ldexp(1.0, math.frexp(largest)[1] - 1)  # a power of two leaves every digit
    levels = np.unique(values / scale)
    levels = levels[np.r_[True, np.diff(levels) > ROUNDED]]
    if len(levels) < 2:
        return 0.0
    apart = np.diff(levels)
    step = float(apart.min())
    for far in FARTHER:  # each finer than the one before can tell
        near = apart[apart < far * step]
        step = float(near.sum() / np.rint(near / step).sum())
    counts = np.r_[0.0, np.cumsum(np.rint(apart / step))]
    off = np.abs((levels - levels[0]) / step - counts)
    few = len(levels) <= min(LEVELS, len(values) // 4)
    return step * scale if off.max() < (ROUGH if few else EXACT) else 0.0
