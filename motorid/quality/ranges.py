"""The range of a normal sample: the constants behind range charts, computed and not copied.

W is the range of n independent readings of standard deviation 1: d2 is its mean and d3 its
standard deviation (Tippett 1925). Every factor of a range chart and of the average-and-range
gauge study follows from the two.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

WIDEST = 16.0  # standard deviations: a wider range is rarer than a double can tell
NODES, POINTS = 160, 1601


@cache
def _moments(n: int) -> tuple[float, float]:
    """Mean and standard deviation of W, by quadrature over P(W > w)."""
    from scipy.special import ndtr

    if n < 2:
        raise ValueError(f"a range needs two readings or more, not {n}")
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    w = (nodes + 1) * WIDEST / 2
    weights = weights * WIDEST / 2
    x = np.linspace(-9.0, 9.0, POINTS)
    inside = (ndtr(x + w[:, None]) - ndtr(x)) ** (n - 1)
    density = np.exp(-0.5 * x**2) / math.sqrt(2.0 * math.pi)
    above = 1.0 - n * np.trapezoid(density * inside, x, axis=1)
    mean = float(weights @ above)
    square = float(weights @ (2 * w * above))
    return mean, math.sqrt(square - mean**2)


def d2(n: int) -> float:
    """Mean range of ``n`` standard normal readings: 1.128 for two."""
    return _moments(n)[0]


def d3(n: int) -> float:
    """Standard deviation of the range of ``n`` standard normal readings: 0.853 for two."""
    return _moments(n)[1]


def d2_star(n: int, groups: int) -> float:
    """What the mean of ``groups`` ranges is divided by to get sigma (Duncan): d2 for many groups.

    Its square has sigma² as its expectation: sqrt(d2² + d3²/groups).
    """
    return math.hypot(d2(n), d3(n) / math.sqrt(groups))


def range_limits(n: int) -> tuple[float, float]:
    """D3 and D4: the three-sigma limits of a range chart over its mean range."""
    spread = 3 * d3(n) / d2(n)
    return max(0.0, 1 - spread), 1 + spread


def a2(n: int) -> float:
    """A2: half the width of an X-bar chart's limits over the mean range."""
    return 3 / (d2(n) * math.sqrt(n))


def degrees_of_freedom(n: int, groups: int) -> float:
    """Degrees of freedom whose chi has the relative spread of ``groups`` mean ranges.

    About 0.9 (n - 1) per group, below n = 8.
    """
    relative = d3(n) / d2(n) / math.sqrt(groups)
    return 0.5 / relative**2 + 0.25  # the spread of chi/sqrt(v) is 1/sqrt(2v - 1/2) to this order


def degrees_of_moving_ranges(count: int) -> float:
    """Degrees of freedom of the mean of the moving ranges of ``count`` readings.

    Ranges that share a reading are correlated (0.2247 between neighbours, half normal), so they
    tell less than separate pairs: about 0.6 of the readings less one.
    """
    ranges = count - 1
    rho = 0.2247 * max(0, ranges - 1) / ranges
    relative = d3(2) / d2(2) * math.sqrt((1 + 2 * rho) / ranges)
    return 0.5 / relative**2 + 0.25
