"""Whether the rows of a balance support a further term, and what its size does to the others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.partial.block_bootstrap_regression import Regression
from motorid.estimate.partial.modulating_functions import COLUMNS

Floats = NDArray[np.float64]

STANDS_OUT = 2.0  # standard deviations, what the choice of width moves among them
NEEDED = 16.0  # of chi-square: a term stands for itself
OVERLAP = 0.5  # independent rows, of rows of bumps that overlap by half


def gain(balance: Regression, place: int, size: float = 0.0) -> float:
    """Of chi-square, by the term of column ``place``; ``size``: of it in the drive already."""
    rows = balance.rows
    others = np.flatnonzero(balance.free & (np.arange(len(balance.free)) != place))
    drive = rows.drive + size * rows.matrix[:, place]
    part = _scaled(rows.matrix[:, others])[0]
    left = drive - part @ np.linalg.lstsq(part, drive, rcond=None)[0]
    before, after = float(left @ left), float(balance.residual @ balance.residual)
    if not after > 0.0:
        return np.inf if before > 0.0 else 0.0
    return OVERLAP * len(rows) * float(np.log(max(before, 1e-300) / after))


def slope(balance: Regression, place: int) -> Floats:
    """By how much (4,) the coefficients by COLUMNS change for each unit of the term of column
    ``place``, the others of the balance following.
    """
    matrix = balance.rows.matrix
    others = np.flatnonzero(balance.free & (np.arange(len(balance.free)) != place))
    part, scale = _scaled(matrix[:, others])
    change = np.zeros(len(balance.free))
    change[others] = -np.linalg.lstsq(part, matrix[:, place], rcond=None)[0] / scale
    return change[: len(COLUMNS)]


def left_open(size: float, deviation: float, usual: float) -> float:
    """What is left of a ``size`` that is taken for 0: by the data, with their ``deviation``, and by
    what is ``usual`` (standard); by the data alone where it stands out.
    """
    if abs(size) > STANDS_OUT * deviation:
        usual = max(usual, abs(size))
    if not usual > 0.0:
        return 0.0
    weight = usual**2 / (usual**2 + deviation**2)
    return float(np.hypot(weight * size, np.sqrt(weight) * deviation))


def _scaled(matrix: Floats) -> tuple[Floats, Floats]:
    scale = np.maximum(np.sqrt((matrix**2).sum(axis=0)), 1e-300)
    return matrix / scale, scale
