"""Readings that determine a direction and are left far more than the others.

Few readings determine L: those after each step. All others say how large the residuals are. What
no model has of a chain stands in those few, and is too little in all to be called a lack of fit.
Where they are surely left more, each counts by what it is left (the HC3 estimate of MacKinnon and
White, 1985).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

SURE = 3.0  # standard deviations by which the readings that tell a direction must be left more
MOST = 0.9  # leverage of a reading; beyond, what it is left says nothing
QUIET = 1.5  # times the declared noise: a channel that is left more has a lack of fit of its own


def of_captures(solution: Solution, records: Sequence[MotorRecord]) -> list[Floats]:
    """Shifts (p,) of a fit that leaves no more than the noise that its channels declare."""
    if any(record.sensed.waveform is not None for record in records):
        return []  # a log declares none, and its stretches are asked first
    lines = list(solution.records)
    quiet = all(
        sigma <= QUIET * block.floor
        for line in lines
        for block, sigma in zip(line.blocks, line.sigmas, strict=True)
    )
    return shifts(lines, covariance_of(solution.information), []) if quiet else []


def shifts(lines: Sequence[Linearised], inverse: Floats, known: Sequence[Floats]) -> list[Floats]:
    """Shifts (p,) by what single readings are left, beyond those that are known.

    ``inverse`` (p, p): the covariance by white noise. In search coordinates.
    """
    rows = np.concatenate([line.orthogonal for line in lines])
    left = np.concatenate([line.residual for line in lines])
    moves = rows @ inverse  # of the parameters, by a unit of each reading
    leverage = np.minimum(np.einsum("np,np->n", moves, rows), MOST)
    squares = (left / (1.0 - leverage)) ** 2
    excess = moves.T @ (moves * squares[:, None]) - moves.T @ moves
    for shift in known:
        excess = excess - np.outer(shift, shift)
    return [shift for shift in ways(excess) if _told(moves, squares, shift)]


def ways(excess: Floats) -> list[Floats]:
    """Of a covariance (p, p), its independent shifts (p,) that are any."""
    sizes, each = np.linalg.eigh(excess)
    return [way * np.sqrt(size) for size, way in zip(sizes, each.T, strict=True) if size > 0]


def _told(moves: Floats, squares: Floats, shift: Floats) -> bool:
    """The readings that move the parameters that way are surely left more than is usual."""
    weights = (moves @ (shift / np.linalg.norm(shift))) ** 2
    more = float(weights @ (squares - 1.0))
    return more > SURE * float(np.sqrt(2.0 * weights @ weights))
