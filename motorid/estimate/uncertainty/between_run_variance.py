"""What runs, or parts of them, show of a fit's uncertainty by how their scores scatter.

A model that lacks something errs at one level as it does not at the next, which the residuals of
white noise would not show: the answers that parts would give alone then differ by more than noise.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.problem import Linearised

Floats = NDArray[np.float64]

LEAST_FREEDOM = 1.5  # degrees of a spread that says anything: three runs have two at most
LEAST = 1e-100  # information below it is none


def pull(line: Linearised, rows: slice | NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """The score (p,) of some residuals of a record, and their information (p, p)."""
    columns = line.orthogonal[rows]
    return project(columns.T, line.residual[rows]), gram(columns.T, columns.T)


def spread_of(pulls: Sequence[tuple[Floats, Floats]], inverse: Floats) -> tuple[Floats, Floats]:
    """Variances (p,) that clusters of residuals show by their scores, and their degrees (p,).

    A cluster that tells much of a parameter has drawn the answer to itself: its score is held
    against what white noise leaves of it, H_c − H_c H⁻¹ H_c.
    """
    informations = np.array([information for _, information in pulls])
    scores = np.array([score for score, _ in pulls])
    scores = scores - informations @ (inverse @ scores.sum(axis=0))  # 0 but at bounds
    white = np.maximum(np.diag(inverse), LEAST)
    reach = inverse @ informations
    shares = np.diagonal(reach @ inverse, axis1=1, axis2=2) / white
    drawn = np.diagonal(reach @ reach @ inverse, axis1=1, axis2=2) / white
    left = (shares - drawn).sum(axis=0)
    squares = (shares**2).sum(axis=0)
    scatter = squares - 2.0 * (shares**3).sum(axis=0) + squares**2
    degrees = (1.0 - squares) ** 2 / np.maximum(scatter, LEAST)
    told = (degrees > LEAST_FREEDOM) & (left > 0.0)
    seen = ((scores @ inverse) ** 2).sum(axis=0)
    return np.where(told, seen / np.where(told, left, 1.0), 0.0), np.maximum(degrees, 1.0)
