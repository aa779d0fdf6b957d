"""Capability (Cp, Cpk, from the spread within subgroups) and performance (Pp, Ppk, overall)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.ranges import d2, degrees_of_freedom, degrees_of_moving_ranges

Floats = NDArray[np.float64]
LEVEL = 0.95


@dataclass(frozen=True)
class Index:
    """An index and its confidence interval; None where one limit alone does not define it."""

    value: float | None
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Capability:
    """``cp``, ``cpk`` by ``sigma_within``; ``pp``, ``ppk`` by ``sigma_overall``.

    ``ppm_expected``: parts per million outside the limits by a normal distribution of the overall
    sigma; ``ppm_seen``: those of the readings. ``normal_p``: Shapiro-Wilk; below 0.05 the indices
    and the parts per million say less than they seem to.
    """

    count: int
    mean: float
    sigma_within: float
    sigma_overall: float
    lower: float | None
    upper: float | None
    cp: Index
    cpk: Index
    pp: Index
    ppk: Index
    ppm_expected: float
    ppm_seen: float
    normal_p: float


def capability(
    values: Floats,
    lower: float | None,
    upper: float | None,
    *,
    subgroup: int = 1,
    level: float = LEVEL,
) -> Capability:
    """Both pairs of indices of ``values`` (n,), in the order of production.

    ``subgroup`` consecutive readings were made under like conditions; 1: moving ranges stand in.
    Intervals within: the range's own degrees of freedom, fewer than n - 1. Raises UsageError
    without a limit or with crossed ones, DataError for too few readings or no spread at all.
    """
    _check_limits(lower, upper)
    n = len(values)
    if n < max(3, 2 * subgroup):
        raise DataError(f"capability needs more than {n} readings: 100 is a usual least")
    mean, overall = float(np.mean(values)), float(np.std(values, ddof=1))
    within, degrees = sigma_within(values, subgroup)
    if overall == 0 or within == 0:
        raise DataError("all readings are equal: there is no spread to judge a process by")
    cp, cpk = indices(mean, within, lower, upper, n, degrees, level)
    pp, ppk = indices(mean, overall, lower, upper, n, n - 1, level)
    return Capability(
        n,
        mean,
        within,
        overall,
        lower,
        upper,
        cp,
        cpk,
        pp,
        ppk,
        _ppm_expected(mean, overall, lower, upper),
        1e6 * float(np.mean(_outside(values, lower, upper))),
        _normality(values),
    )


def _check_limits(lower: float | None, upper: float | None) -> None:
    if lower is None and upper is None:
        raise UsageError("capability is against limits: give a lower one, an upper one or both")
    if lower is not None and upper is not None and not lower < upper:
        raise UsageError(f"the lower limit {lower:g} does not lie below the upper one {upper:g}")


def sigma_within(values: Floats, subgroup: int = 1) -> tuple[float, float]:
    """Standard deviation within subgroups by mean range over d2, and its degrees of freedom."""
    if subgroup == 1:
        ranges = np.abs(np.diff(values))
        return float(ranges.mean()) / d2(2), degrees_of_moving_ranges(len(values))
    groups = len(values) // subgroup
    ranges = np.ptp(values[: groups * subgroup].reshape(groups, subgroup), axis=1)
    return float(ranges.mean()) / d2(subgroup), degrees_of_freedom(subgroup, groups)


def indices(
    mean: float,
    sigma: float,
    lower: float | None,
    upper: float | None,
    count: int,
    degrees: float,
    level: float = LEVEL,
) -> tuple[Index, Index]:
    """The pair (Cp, Cpk) for a mean of ``count`` readings and a sigma of so many degrees.

    The interval of Cp is exact (chi-square); that of Cpk is Bissell's normal approximation.
    """
    from scipy.stats import chi2, norm

    sides = [(upper - mean) / (3 * sigma)] if upper is not None else []
    sides += [(mean - lower) / (3 * sigma)] if lower is not None else []
    cpk = min(sides)
    half = norm.ppf((1 + level) / 2) * math.sqrt(1 / (9 * count) + cpk**2 / (2 * degrees))
    second = Index(cpk, (cpk - float(half), cpk + float(half)))
    if lower is None or upper is None:
        return Index(None, None), second
    cp = (upper - lower) / (6 * sigma)
    low, high = np.sqrt(chi2.ppf([(1 - level) / 2, (1 + level) / 2], degrees) / degrees)
    return Index(cp, (cp * float(low), cp * float(high))), second


def _outside(values: Floats, lower: float | None, upper: float | None) -> NDArray[np.bool_]:
    below = values < (-math.inf if lower is None else lower)
    above = values > (math.inf if upper is None else upper)
    return np.asarray(below | above)


def _ppm_expected(mean: float, sigma: float, lower: float | None, upper: float | None) -> float:
    from scipy.stats import norm

    below = 0.0 if lower is None else float(norm.cdf((lower - mean) / sigma))
    above = 0.0 if upper is None else float(norm.sf((upper - mean) / sigma))
    return 1e6 * (below + above)


def _normality(values: Floats) -> float:
    """Shapiro-Wilk's p; beyond 5,000 readings of an even thinning, which the test is made for."""
    from scipy.stats import shapiro

    step = math.ceil(len(values) / 5000)
    return float(shapiro(values[::step]).pvalue)
