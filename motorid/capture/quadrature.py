"""The two lines of an encoder, as a logic analyser records them, become counts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError

Floats = NDArray[np.float64]
NAME = "quadrature"  # of the function in the arithmetic of a map
# place of each state (A high, B high) along the cycle low-low, high-low, high-high, low-high
_PLACE = np.array([[0, 3], [1, 2]], dtype=np.int64)


def counts(a: Floats, b: Floats) -> Floats:
    """Edges counted up and down, (rows,), from 0: up where A rises while B is low.

    A line is high above the middle of its range. A reading without a number keeps the count. Raises
    DataError where both lines change between two rows: then the direction is unknown.
    """
    known = np.isfinite(a) & np.isfinite(b)
    place = _PLACE[_high(a)[known], _high(b)[known]]
    steps = (np.diff(place) + 1) % 4 - 1  # -1, 0, 1; 2: both lines changed
    both = steps == 2
    if both.any():
        row = int(np.flatnonzero(known)[1:][np.argmax(both)])
        raise DataError(
            f"both lines of the encoder change at once in row {row + 1} ({int(both.sum())} times "
            "in all), so that edges were lost: record them at a higher rate"
        )
    found = np.full(len(a), np.nan)
    found[known] = np.concatenate([[0.0], np.cumsum(steps)])[: known.sum()]
    return found


def _high(line: Floats) -> NDArray[np.int64]:
    known = line[np.isfinite(line)]
    middle = 0.5 * (known.min() + known.max()) if len(known) else 0.0
    return (np.nan_to_num(line) > middle).astype(np.int64)


def is_pair(a: Floats, b: Floats, fewest: int) -> bool:
    """Whether two columns, (rows,) each, are such lines: two levels, and so many edges or more."""
    if not len(a) or any(set(np.unique(line)) != {0.0, 1.0} for line in (a, b)):
        return False
    try:
        return bool(np.abs(np.diff(counts(a, b))).sum() >= fewest)
    except DataError:
        return False
