"""Control charts: X-bar with R for subgroups, individuals with moving ranges, and drift."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.ranges import d2, d3, range_limits
from motorid.quality.rules import LIMITS, SETS, Alarm, RuleSet, alarms

Floats = NDArray[np.float64]
THREE_SIGMA = 0.0027  # how often a process in control shows a point beyond its limits


@dataclass(frozen=True)
class Chart:
    """Points (k,) about ``centre`` with ``lower`` and ``upper`` control limits.

    ``sigma`` is the standard deviation of a point. The first ``baseline`` points set the limits.
    ``first`` is the number of the reading (or subgroup) that point 0 belongs to.
    """

    name: str
    points: Floats
    centre: float
    lower: float
    upper: float
    sigma: float
    baseline: int
    alarms: tuple[Alarm, ...]
    first: int = 0


def xbar_r(
    subgroups: Floats, *, baseline: int | None = None, rules: RuleSet = "western-electric"
) -> tuple[Chart, Chart]:
    """The X-bar and R charts of ``subgroups`` (k, n); ``baseline`` first ones set the limits.

    Run rules read the X-bar chart; the R chart, whose points are skewed, has its limits alone.
    Raises DataError for subgroups of fewer than 2 or more than 25, or fewer than 2 subgroups.
    """
    k, n = subgroups.shape
    if not 2 <= n <= 25 or k < 2:
        raise DataError(
            f"an X-bar chart needs subgroups of 2 to 25 and two of them, not {k} of {n}"
        )
    base = _baseline(baseline, k)
    means, ranges = subgroups.mean(axis=1), np.ptp(subgroups, axis=1)
    centre, width = float(means[:base].mean()), float(ranges[:base].mean())
    _needs_spread(width)
    sigma = width / d2(n)
    of_mean = sigma / math.sqrt(n)
    low, high = range_limits(n)
    return (
        _chart("X-bar", means, centre, 3 * of_mean, of_mean, base, rules),
        _ranges("R", ranges, width, (low, high), d3(n) * sigma, base),
    )


def i_mr(
    values: Floats, *, baseline: int | None = None, rules: RuleSet = "western-electric"
) -> tuple[Chart, Chart]:
    """The individuals and moving-range charts of ``values`` (n,), in order.

    Raises DataError below three readings or where the baseline does not vary.
    """
    if len(values) < 3:
        raise DataError(f"a chart of individuals needs three readings or more, not {len(values)}")
    base = max(2, _baseline(baseline, len(values)))
    moving = np.abs(np.diff(values))
    width = float(moving[: base - 1].mean())
    _needs_spread(width)
    sigma = width / d2(2)
    centre = float(values[:base].mean())
    chart = _chart("individuals", values, centre, 3 * sigma, sigma, base, rules)
    return chart, _ranges(
        "moving range", moving, width, range_limits(2), d3(2) * sigma, base - 1, first=1
    )


def _baseline(asked: int | None, available: int) -> int:
    if asked is None:
        return available
    if not 2 <= asked <= available:
        raise UsageError(f"a baseline is 2 points to all {available} of them, not {asked}")
    return asked


def _needs_spread(width: float) -> None:
    if width == 0:
        raise DataError("the baseline's readings are all equal: no limits follow from them")


def _chart(
    name: str, points: Floats, centre: float, half: float, sigma: float, base: int, rules: RuleSet
) -> Chart:
    found = alarms((points - centre) / sigma, SETS[rules])
    return Chart(name, points, centre, centre - half, centre + half, sigma, base, found)


def _ranges(
    name: str,
    points: Floats,
    width: float,
    factors: tuple[float, float],
    sigma: float,
    base: int,
    first: int = 0,
) -> Chart:
    found = alarms((points - width) / sigma, LIMITS)
    lower, upper = factors[0] * width, factors[1] * width
    return Chart(name, points, width, lower, upper, sigma, base, found, first)


@dataclass(frozen=True)
class Drift:
    """A straight line through readings of a golden motor over time.

    ``per_day`` in the quantity's unit, with its 95 % interval; ``p``: how likely so steep a line
    is where nothing drifts. ``total``: what the line moves over the span of the readings.
    """

    count: int
    days: float
    per_day: float
    interval_95: tuple[float, float]
    p: float
    total: float

    @property
    def significant(self) -> bool:
        """As rare, where nothing drifts, as a point beyond three sigma."""
        return self.p < THREE_SIGMA


def drift(days: Floats, values: Floats) -> Drift:
    """The drift of ``values`` (n,) measured at ``days`` (n,). Raises DataError below three."""
    from scipy.stats import linregress
    from scipy.stats import t as student

    n = len(values)
    span = float(np.ptp(days)) if n else 0.0
    if n < 3 or span == 0:
        raise DataError("drift needs three readings or more, at different times")
    line: Any = linregress(days, values)
    half = float(student.ppf(0.975, n - 2)) * float(line.stderr)
    slope = float(line.slope)
    return Drift(n, span, slope, (slope - half, slope + half), float(line.pvalue), slope * span)
