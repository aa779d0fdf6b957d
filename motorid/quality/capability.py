"""Capability (Cp, Cpk, from the spread within subgroups) and performance (Pp, Ppk, overall)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.ranges import d2, degrees_of_freedom, degrees_of_moving_ranges
from motorid.quality.skewed import (
    LEAST,
    LEAST_MOMENTS,
    STEEPEST,
    Performance,
    Shape,
    by_box_cox,
    by_percentiles,
    normality,
)

Floats = NDArray[np.float64]
Asked = Literal["auto", "normal", "box-cox", "percentile"]
LEVEL = 0.95
NOT_NORMAL = 0.05  # of Shapiro and Wilk's p


@dataclass(frozen=True)
class Index:
    """An index and its confidence interval; None where limits or shape do not define it."""

    value: float | None
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class Capability:
    """``cp``, ``cpk`` by ``sigma_within``; ``pp``, ``ppk`` by ``sigma_overall``.

    ``ppm_expected``: parts per million outside the limits by the ``shape``; ``ppm_seen``: those of
    the readings. ``normal_p``: Shapiro-Wilk of the readings. ``why`` says how the shape was chosen.
    ``fit_p``: the same test of the normal scores that the shape gives; below 0.05 it does not fit.
    ``power``: Box-Cox's. ``percentiles``: 0.135 %, median and 99.865 %; of a skewed shape alone.
    Cp and Cpk are of a normal shape alone.
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
    shape: Shape = "normal"
    why: str = ""
    fit_p: float = 1.0
    power: float | None = None
    percentiles: tuple[float, float, float] | None = None


def capability(
    values: Floats,
    lower: float | None,
    upper: float | None,
    *,
    subgroup: int = 1,
    level: float = LEVEL,
    shape: Asked = "auto",
    power: float | None = None,
) -> Capability:
    """Both pairs of indices of ``values`` (n,), in the order of production.

    ``subgroup`` consecutive readings were made under like conditions; 1: moving ranges stand in.
    Intervals within: the range's own degrees of freedom, fewer than n - 1. ``shape`` "auto": normal
    where Shapiro and Wilk's test does not reject it; else Box-Cox where it makes the readings pass
    that test; else percentiles. ``power``: a λ that is known, of "box-cox". Raises UsageError
    without a limit or with crossed ones, or for a shape that these readings and limits cannot
    have, DataError for too few readings or no spread.
    """
    _check_limits(lower, upper)
    n = len(values)
    if n < max(3, 2 * subgroup):
        raise DataError(f"capability needs more than {n} readings: 100 is a usual least")
    with np.errstate(over="ignore"):
        mean, overall = float(np.mean(values)), float(np.std(values, ddof=1))
    if not math.isfinite(overall):
        raise DataError("the readings are too large to judge a process by: are they of one unit?")
    within, degrees = sigma_within(values, subgroup)
    if overall == 0 or within == 0:
        raise DataError("all readings are equal: there is no spread to judge a process by")
    normal_p = normality(values)
    if power is not None and (shape != "box-cox" or not abs(power) <= STEEPEST):
        raise UsageError(f"a power of {power:g}: it goes with box-cox, and lies between -5 and 5")
    found, why = _shaped(values, lower, upper, level, shape, normal_p, power)
    seen = 1e6 * float(np.mean(_outside(values, lower, upper)))
    about = (n, mean, within, overall, lower, upper)
    if found is not None:
        none = Index(None, None)
        pp = none if found.pp is None else Index(found.pp[0], found.pp[1:])
        ppk = Index(found.ppk[0], found.ppk[1:])
        return Capability(
            *about, none, none, pp, ppk, 1e6 * found.outside, seen, normal_p,
            found.shape, why, found.p, found.power, found.percentiles,
        )  # fmt: skip
    cp, cpk = indices(mean, within, lower, upper, n, degrees, level)
    pp, ppk = indices(mean, overall, lower, upper, n, n - 1, level)
    expected = _ppm_expected(mean, overall, lower, upper)
    return Capability(*about, cp, cpk, pp, ppk, expected, seen, normal_p, why=why, fit_p=normal_p)


def _shaped(
    values: Floats,
    lower: float | None,
    upper: float | None,
    level: float,
    shape: Asked,
    normal_p: float,
    known: float | None = None,
) -> tuple[Performance | None, str]:
    """The performance by the shape that is asked for or chosen, and why; None: a normal one."""
    n, ends = len(values), (lower, upper)
    tested = f"Shapiro-Wilk p = {normal_p:.2g}"
    too_few = f"normal, though the readings contradict it ({tested}): too few for another"
    if shape == "normal":
        return None, "normal, as asked"
    if shape == "auto":
        if normal_p >= NOT_NORMAL:
            return None, f"normal: the readings do not contradict it ({tested})"
        if n < LEAST:
            return None, too_few
        power = by_box_cox(values, *ends, level)
        if power is not None and power.p >= NOT_NORMAL:
            return power, (
                f"Box-Cox: the readings are not normal ({tested}), but are after the power "
                f"transform of λ = {power.power:.2f}"
            )
        if n < LEAST_MOMENTS:
            return None, too_few
        try:
            return by_percentiles(values, *ends, level), (
                f"percentiles of Pearson's curve: the readings are not normal ({tested}), "
                "and no power makes them so"
            )
        except DataError:
            return (
                None,
                f"normal, though the readings contradict it ({tested}): no other shape fits",
            )
    least = LEAST if shape == "box-cox" else LEAST_MOMENTS
    if n < least:
        raise DataError(f"capability by {shape} needs {least} readings or more, not {n}")
    if shape == "percentile":
        return by_percentiles(values, *ends, level), "percentiles of Pearson's curve, as asked"
    found = by_box_cox(values, *ends, level, known)
    if found is None:
        raise UsageError(
            "Box-Cox needs positive readings and limits, and a power between -5 and 5: take "
            "percentiles"
        )
    return found, f"Box-Cox of λ = {found.power:.2f}, as asked"


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
    from scipy.special import gammaincinv, ndtri

    sides = [(upper - mean) / (3 * sigma)] if upper is not None else []
    sides += [(mean - lower) / (3 * sigma)] if lower is not None else []
    cpk = min(sides)
    half = ndtri((1 + level) / 2) * math.sqrt(1 / (9 * count) + cpk**2 / (2 * degrees))
    second = Index(cpk, (cpk - float(half), cpk + float(half)))
    if lower is None or upper is None:
        return Index(None, None), second
    cp = (upper - lower) / (6 * sigma)
    tails = [(1 - level) / 2, (1 + level) / 2]
    low, high = np.sqrt(2 * gammaincinv(degrees / 2, tails) / degrees)  # of chi-square
    return Index(cp, (cp * float(low), cp * float(high))), second


def _outside(values: Floats, lower: float | None, upper: float | None) -> NDArray[np.bool_]:
    below = values < (-math.inf if lower is None else lower)
    above = values > (math.inf if upper is None else upper)
    return np.asarray(below | above)


def _ppm_expected(mean: float, sigma: float, lower: float | None, upper: float | None) -> float:
    from scipy.special import ndtr

    below = 0.0 if lower is None else float(ndtr((lower - mean) / sigma))
    above = 0.0 if upper is None else float(ndtr((mean - upper) / sigma))
    return 1e6 * (below + above)
