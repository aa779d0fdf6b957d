"""Small plots for a terminal: lines of characters, of two by four dots each."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LINES, DOTS = 2, 4  # lines of characters, unless told; dots one above the other in each
# bits of a braille character, from the top dot to the bottom one, left and right
_BITS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))
_BLANK = 0x2800
_PLAIN = {True: "*", False: " "}


def plot(values: Floats, width: int, *, lines: int = LINES, plain: bool = False) -> list[str]:
    """``values`` (n,) over their range as ``lines`` of ``width`` characters, the upper one first.

    Each column of dots spans the values of its share of the rows; NaN leave it blank. ``plain``:
    for a terminal without braille.
    """
    columns = width if plain else 2 * width
    levels = lines * DOTS if not plain else lines
    dots = _dots(np.asarray(values, dtype=np.float64), columns, levels)
    if plain:
        return ["".join(_PLAIN[bool(dot)] for dot in row) for row in dots]
    return [_line(dots[line * DOTS : (line + 1) * DOTS]) for line in range(lines)]


def _dots(values: Floats, columns: int, levels: int) -> NDArray[np.bool_]:
    """(levels, columns), the highest level first."""
    dots = np.zeros((levels, columns), dtype=np.bool_)
    finite = values[np.isfinite(values)]
    if not len(finite):
        return dots
    low, high = float(finite.min()), float(finite.max())
    size = (high - low) or 1.0
    edges = np.linspace(0, len(values), columns + 1)
    for column in range(columns):
        first = min(int(edges[column]), len(values) - 1)
        part = values[first : max(int(edges[column + 1]), first + 1)]
        part = part[np.isfinite(part)]
        if len(part):
            span = (np.array([part.min(), part.max()]) - low) / size
            bottom, top = np.clip((span * levels).astype(int), 0, levels - 1)
            dots[levels - 1 - top : levels - bottom, column] = True
    return dots


def _line(dots: NDArray[np.bool_]) -> str:
    """A line of characters from (DOTS, columns) dots."""
    found = []
    for left in range(0, dots.shape[1], 2):
        bits = [
            bit
            for side in range(2)
            for row, bit in enumerate(_BITS[side])
            if dots[row, left + side]
        ]
        found.append(chr(_BLANK + sum(bits)))
    return "".join(found)
