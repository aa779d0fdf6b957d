"""Shapiro and Wilk's test of normality, by Royston's algorithm R94 (Applied Statistics 44, 1995).

    W = (sum of a_i x_(i))² / sum of (x_i - mean)²

``scipy.stats.shapiro`` computes the same. Its package takes most of a second to import, which is
longer than a trend of a history takes altogether.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LAST = (0.0, 0.221157, -0.147981, -2.07119, 4.434685, -2.706056)  # of 1/sqrt(n): a_n - c_n
LAST_BUT_ONE = (0.0, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633)
FEW = 11  # readings, up to which -log(g - log(1 - W)) is normal, and beyond which log(1 - W)
G = (-2.273, 0.459)  # of n
MEAN_OF_FEW = (0.544, -0.39978, 0.025054, -6.714e-4)  # of n
LOG_SD_OF_FEW = (1.3822, -0.77857, 0.062767, -0.0020322)
MEAN = (-1.5861, -0.31082, -0.083751, 0.0038915)  # of log n
LOG_SD = (-0.4803, -0.082676, 0.0030302)
LEAST_P = 1e-99


def shapiro_wilk(values: Floats) -> float:
    """How likely so small a W is where ``values`` (3 to 5,000) are normal; 1 if all are equal."""
    ordered = np.sort(values)
    a = _weights(len(ordered))
    about = ordered - ordered.mean()
    if ordered[0] == ordered[-1]:
        return 1.0
    w = min(1.0, float(a @ about) ** 2 / float(about @ about))
    return _p(w, len(ordered))


def _weights(n: int) -> Floats:
    from scipy.special import ndtri

    if n == 3:
        return np.array([-1.0, 0.0, 1.0]) / math.sqrt(2.0)
    m = ndtri((np.arange(1, n + 1) - 0.375) / (n + 0.25))  # normal scores, nearly
    square, u = float(m @ m), 1.0 / math.sqrt(n)
    last = m[-1] / math.sqrt(square) + polyval(u, LAST)
    ends = [last]
    if n > 5:
        ends.append(m[-2] / math.sqrt(square) + polyval(u, LAST_BUT_ONE))
    rest = square - 2.0 * sum(m[-k - 1] ** 2 for k in range(len(ends)))
    a = m * math.sqrt((1.0 - 2.0 * sum(one**2 for one in ends)) / rest)
    for k, one in enumerate(ends):
        a[-k - 1], a[k] = one, -one
    return np.asarray(a)


def _p(w: float, n: int) -> float:
    from scipy.special import ndtr

    if n == 3:
        return max(0.0, 6.0 / math.pi * (math.asin(math.sqrt(w)) - math.asin(math.sqrt(0.75))))
    y = math.log1p(-w) if w < 1.0 else -math.inf
    if n > FEW:
        log_n = math.log(n)
        mean, sd = polyval(log_n, MEAN), math.exp(polyval(log_n, LOG_SD))
    else:
        if y >= polyval(n, G):
            return LEAST_P
        y = -math.log(polyval(n, G) - y)
        mean, sd = polyval(n, MEAN_OF_FEW), math.exp(polyval(n, LOG_SD_OF_FEW))
    return float(ndtr((mean - y) / sd))
