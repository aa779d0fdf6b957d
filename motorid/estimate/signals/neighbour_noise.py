"""The noise of readings by what neighbours differ by."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HALF_BELOW = 0.6745  # standard deviations within which half of normal readings lie


def neighbour_noise(values: Floats, order: int = 2) -> float:
    """Standard deviation of readings (n,), rounding and all; 0: too few.

    By the median of their differences of that ``order``, in which a polynomial of a lower one
    leaves nothing and a few jumps count for little.
    """
    left = np.abs(np.diff(values, order))
    if not len(left):
        return 0.0
    return float(np.median(left)) / HALF_BELOW / math.sqrt(math.comb(2 * order, order))
