"""A straight line through points that are uncertain in both directions.

York et al., "Unified equations for the slope, intercept, and standard errors of the best straight
line", Am. J. Phys. 72 (2004) 367; the same line as ISO/TS 28037 for uncorrelated errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from motorid.errors import DataError

MOST_PASSES = 200
SETTLED = 1e-14  # relative change of the slope


@dataclass(frozen=True)
class Line:
    """y = intercept + slope x, with standard uncertainties and the covariance of the two."""

    intercept: float
    slope: float
    intercept_uncertainty: float
    slope_uncertainty: float
    covariance: float
    chi_square: float
    degrees_of_freedom: int

    @property
    def excess(self) -> float:
        """How far the points scatter beyond their uncertainties (Birge ratio); 1 if they do not."""
        if self.degrees_of_freedom < 1:
            return 1.0
        return max(1.0, math.sqrt(self.chi_square / self.degrees_of_freedom))


def fit_line(x: ArrayLike, y: ArrayLike, u_x: ArrayLike, u_y: ArrayLike) -> Line:
    """The line through points (n,) with standard uncertainties (n,) of x and of y.

    Raises DataError for fewer than two points, for points that all have one x, and for a point
    without any uncertainty.
    """
    x, y, u_x, u_y = (np.asarray(a, dtype=np.float64) for a in (x, y, u_x, u_y))
    if len(x) < 2 or np.ptp(x) == 0:
        raise DataError("a gain needs readings at two different levels or more")
    if np.any((u_x <= 0) & (u_y <= 0)):
        raise DataError("a point without any uncertainty has no weight in a line: state one")
    slope = float(np.polyfit(x, y, 1)[0])
    for _ in range(MOST_PASSES):
        weights = 1 / (u_y**2 + (slope * u_x) ** 2)
        mean_x, mean_y = (float(weights @ a / weights.sum()) for a in (x, y))
        u, v = x - mean_x, y - mean_y
        shift = weights * (u * u_y**2 + slope * v * u_x**2)  # York's beta, without correlation
        before, slope = slope, float((weights * shift) @ v / ((weights * shift) @ u))
        if abs(slope - before) <= SETTLED * abs(slope):
            break
    intercept = mean_y - slope * mean_x
    adjusted = mean_x + shift  # the points moved onto the line
    middle = float(weights @ adjusted / weights.sum())
    variance = 1 / float(weights @ (adjusted - middle) ** 2)
    residual = y - intercept - slope * x
    return Line(
        intercept=intercept,
        slope=slope,
        intercept_uncertainty=math.sqrt(1 / weights.sum() + middle**2 * variance),
        slope_uncertainty=math.sqrt(variance),
        covariance=-middle * variance,
        chi_square=float(weights @ residual**2),
        degrees_of_freedom=len(x) - 2,
    )
