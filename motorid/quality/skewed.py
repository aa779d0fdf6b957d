"""Performance of a process that is not normal: by percentiles of Pearson's curve, or by Box-Cox.

Percentiles (ISO 22514-2; Clements 1989), with X the quantiles of the process:

    Pp = (U - L) / (X99.865 - X0.135)        PpkU = (U - X50) / (X99.865 - X50), PpkL likewise

Box-Cox (1964): y = (x^λ - 1)/λ, with λ of the largest likelihood; Pp and Ppk are of y and of the
limits' own y.

Intervals are by a bootstrap in which λ and the curve are found again each time: its percentiles
for Box-Cox; for the percentiles, whose moments make Ppk too large, the normal interval of its
logarithm less the bias that the bootstrap shows (Davison and Hinkley 1997, 5.5).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.quality.pearson_curve import PearsonCurve, curve_of
from motorid.quality.shapiro_wilk import shapiro_wilk

Floats = NDArray[np.float64]
Shape = Literal["normal", "box-cox", "percentile"]
TAIL = 0.00135  # beyond three sigma of a normal process, on each side
LEAST = 30  # readings that show a power
LEAST_MOMENTS = 50  # readings that show a skewness and a kurtosis
DRAWS, SEED = 1000, 1964  # of the bootstrap
MOST_BINS = 5000  # more readings are resampled as so many means of neighbours
STEEPEST = 5.0  # of λ: what needs more is no case for a power
GRID, REACH = 201, 8.0  # of λ in the bootstrap: points, and standard deviations about the best
LARGEST = 2e7  # numbers in a block of the bootstrap
MODERATE = 600.0  # of a logarithm: e to it is a double


@dataclass(frozen=True)
class Performance:
    """``pp``, ``ppk`` None where the limits do not define them; each with its interval.

    ``percentiles``: 0.135 %, median, 99.865 %. ``outside``: expected share beyond the limits.
    ``p``: of Shapiro and Wilk's test of the normal scores; below 0.05 the shape does not fit.
    """

    shape: Shape
    pp: tuple[float, float, float] | None
    ppk: tuple[float, float, float]
    percentiles: tuple[float, float, float]
    outside: float
    p: float
    power: float | None = None


def normality(values: Floats) -> float:
    """Shapiro-Wilk's p; beyond 5,000 readings of an even thinning, which the test is made for."""
    step = math.ceil(len(values) / 5000)
    return shapiro_wilk(values[::step])


# ---- percentiles -------------------------------------------------------------------------------


def by_percentiles(
    values: Floats, lower: float | None, upper: float | None, level: float
) -> Performance:
    """Performance of ``values`` (n,) by the percentiles of their Pearson curve.

    Raises DataError where they have none, as readings of two values alone.
    """
    with np.errstate(all="ignore"):  # a resample without spread has no curve, and is left out
        return _by_percentiles(values, lower, upper, level)


def _by_percentiles(
    values: Floats, lower: float | None, upper: float | None, level: float
) -> Performance:
    curve = curve_of(values)
    low, middle, high = (curve.quantile(p) for p in (TAIL, 0.5, 1.0 - TAIL))
    value = _by_quantiles(low, middle, high, lower, upper)
    drawn = _resampled_curve(values)
    least, half, most = (drawn.quantile(p) for p in (TAIL, 0.5, 1.0 - TAIL))
    spread = _by_quantiles(least, half, most, lower, upper)
    below = 0.0 if lower is None else curve.cdf(lower)
    above = 0.0 if upper is None else 1.0 - curve.cdf(upper)
    return Performance(
        "percentile",
        *_with_intervals(value, spread, level, _less_bias),
        (float(low[0]), float(middle[0]), float(high[0])),
        below + above,
        normality(_scores(curve, values)),
    )


def _by_quantiles(
    low: Floats, middle: Floats, high: Floats, lower: float | None, upper: float | None
) -> tuple[Floats | None, Floats]:
    sides = [(upper - middle) / (high - middle)] if upper is not None else []
    sides += [(middle - lower) / (middle - low)] if lower is not None else []
    pp = None if lower is None or upper is None else (upper - lower) / (high - low)
    return pp, np.min(sides, axis=0)


def _scores(curve: PearsonCurve, values: Floats) -> Floats:
    """The standard normal deviates of as large a share below as the curve has below ``values``."""
    from scipy.special import ndtri

    shares = np.concatenate([np.geomspace(1e-7, 0.02, 60), np.linspace(0.02, 0.5, 100)[1:]])
    shares = np.concatenate([shares, 1.0 - shares[-2::-1]])
    places = np.array([curve.quantile(float(p))[0] for p in shares])
    rising = np.concatenate([[True], np.diff(places) > 0.0])
    return np.asarray(np.interp(values, places[rising], ndtri(shares[rising])))


def _resampled_curve(values: Floats) -> PearsonCurve:
    """The curves of the resampled readings, by their moments."""
    count = len(values)
    centre, scale = float(values.mean()), float(values.std())
    bins, shares = _bins((values - centre) / scale)
    powers = np.stack([bins, bins**2, bins**3, bins**4], axis=1)
    m1, m2, m3, m4 = (_resampled(powers, shares, count) / count).T
    second = m2 - m1**2
    third = m3 - 3.0 * m1 * m2 + 2.0 * m1**3
    fourth = m4 - 4.0 * m1 * m3 + 6.0 * m1**2 * m2 - 3.0 * m1**4
    skew = third / second**1.5 * math.sqrt(count * (count - 1.0)) / (count - 2.0)
    excess = fourth / second**2 - 3.0
    excess = (count - 1.0) / ((count - 2.0) * (count - 3.0)) * ((count + 1.0) * excess + 6.0)
    sd = scale * np.sqrt(second * count / (count - 1.0))
    return PearsonCurve(centre + scale * m1, sd, skew, excess)


# ---- Box-Cox -----------------------------------------------------------------------------------


def box_cox(values: Floats | float, power: Floats | float) -> Floats:
    """The transform of positive ``values``: their logarithm where ``power`` is 0."""
    from scipy.special import boxcox

    return np.asarray(boxcox(values, power))


def best_power(values: Floats) -> float | None:
    """λ of the largest likelihood; None where the readings need a steeper one than ``STEEPEST``."""
    from scipy.optimize import minimize_scalar

    scaled = values / float(np.exp(np.log(values).mean()))
    most = _most(scaled)

    def cost(power: float) -> float:
        return float(np.log(box_cox(scaled, power).std()))

    found = float(minimize_scalar(cost, bounds=(-most, most), method="bounded").x)
    return None if abs(found) > 0.99 * most else found


def _most(scaled: Floats) -> float:
    """The steepest λ that readings about 1 allow without an overflow."""
    return min(STEEPEST, MODERATE / max(1.0, float(np.abs(np.log(scaled)).max())))


def by_box_cox(
    values: Floats,
    lower: float | None,
    upper: float | None,
    level: float,
    known: float | None = None,
) -> Performance | None:
    """Performance of ``values`` (n,) by a power transform; None where none is defined.

    Readings and limits must be positive. ``known``: λ, where it is not to be found.
    """
    ends = [end for end in (lower, upper) if end is not None]
    if not (values > 0.0).all() or not all(end > 0.0 for end in ends):
        return None
    unit = float(np.exp(np.log(values).mean()))
    scaled = values / unit
    power = best_power(values) if known is None else known
    if power is None or any(abs(math.log(end / unit)) * STEEPEST > MODERATE for end in ends):
        return None
    shown = box_cox(scaled, power)
    mean, sd = float(shown.mean()), float(shown.std(ddof=1))
    low, high = (None if end is None else end / unit for end in (lower, upper))
    value = _by_moments(np.array([mean]), np.array([sd]), np.array([power]), low, high)
    spread = _by_moments(*_resampled_powers(scaled, power, known is None), low, high)
    from scipy.special import ndtr

    def at(deviations: float) -> float:
        return unit * _back(mean + deviations * sd, power)

    def score(end: float) -> float:
        return (float(box_cox(end, power)) - mean) / sd

    below = 0.0 if low is None else float(ndtr(score(low)))
    above = 0.0 if high is None else float(ndtr(-score(high)))
    return Performance(
        "box-cox",
        *_with_intervals(value, spread, level, _percentiles),
        (at(-3.0), at(0.0), at(3.0)),
        below + above,
        normality(shown),
        power,
    )


def _back(shown: float, power: float) -> float:
    """The reading of a transformed one; infinite, or 0, where the transform does not reach it."""
    if power == 0.0:
        return math.exp(shown)
    base = 1.0 + power * shown
    if base <= 0.0:
        return 0.0 if power > 0.0 else math.inf
    return float(base ** (1.0 / power))


def _by_moments(
    mean: Floats, sd: Floats, power: Floats, lower: float | None, upper: float | None
) -> tuple[Floats | None, Floats]:
    low, high = (None if end is None else box_cox(end, power) for end in (lower, upper))
    sides = [(high - mean) / (3.0 * sd)] if high is not None else []
    sides += [(mean - low) / (3.0 * sd)] if low is not None else []
    pp = None if low is None or high is None else (high - low) / (6.0 * sd)
    return pp, np.min(sides, axis=0)


def _resampled_powers(scaled: Floats, power: float, search: bool) -> tuple[Floats, Floats, Floats]:
    """Mean and standard deviation of the transform, and λ, of each resample: the best on a grid.

    The grid is about the readings' own ``power``, as wide as λ may be off by: about 1/√n over the
    standard deviation of their logarithms. ``scaled`` readings have a geometric mean of 1; that of
    a resample enters its likelihood.
    """
    count = len(scaled)
    bins, shares = _bins(scaled)
    logs = np.log(bins)
    most = _most(bins)
    reach = REACH / (math.sqrt(count) * max(float(logs.std()), 1e-12))
    grid = np.array([power])
    if search:
        grid = np.linspace(max(-most, power - reach), min(most, power + reach), GRID)
    shown = np.stack([box_cox(bins, float(g)) for g in grid], axis=1)
    sums = _resampled(np.column_stack([shown, shown**2, logs]), shares, count) / count
    tried = len(grid)
    means, squares, log_mean = sums[:, :tried], sums[:, tried : 2 * tried], sums[:, -1:]
    variances = np.maximum(squares - means**2, 1e-300)
    best = np.argmin(0.5 * np.log(variances) - grid * log_mean, axis=1)
    rows = np.arange(len(best))
    sd = np.sqrt(variances[rows, best] * count / (count - 1.0))
    return means[rows, best], sd, grid[best]


# ---- the bootstrap -----------------------------------------------------------------------------


def _bins(values: Floats) -> tuple[Floats, Floats]:
    """The readings and the share of each; of many, the means of neighbours and their shares."""
    count = len(values)
    each = math.ceil(count / MOST_BINS)
    starts = np.arange(0, count, each)
    sizes = np.diff(np.append(starts, count))
    return np.add.reduceat(np.sort(values), starts) / sizes, sizes / count


def _resampled(columns: Floats, shares: Floats, count: int) -> Floats:
    """Sums (DRAWS, k) of ``columns`` (n, k) over resamples of ``count``, by how often each came."""
    draw = np.random.default_rng(SEED)
    block = max(1, int(LARGEST // len(columns)))
    done = []
    for start in range(0, DRAWS, block):
        often = draw.multinomial(count, shares, size=min(block, DRAWS - start))
        done.append(often @ columns)
    return np.concatenate(done)


Interval = Callable[[float, Floats, float], tuple[float, float]]


def _percentiles(_: float, drawn: Floats, level: float) -> tuple[float, float]:
    low, high = np.quantile(drawn, [(1.0 - level) / 2.0, (1.0 + level) / 2.0])
    return float(low), float(high)


def _less_bias(value: float, drawn: Floats, level: float) -> tuple[float, float]:
    """An index that may be zero or less has no logarithm: then the percentiles."""
    from scipy.special import ndtri

    if value <= 0.0 or (drawn <= 0.0).any():
        return _percentiles(value, drawn, level)
    logs = np.log(drawn)
    middle = 2.0 * math.log(value) - float(logs.mean())
    half = float(ndtri((1.0 + level) / 2.0)) * float(logs.std())
    return math.exp(middle - half), math.exp(middle + half)


def _with_intervals(
    value: tuple[Floats | None, Floats],
    spread: tuple[Floats | None, Floats],
    level: float,
    interval: Interval,
) -> tuple[tuple[float, float, float] | None, tuple[float, float, float]]:
    """Value, low and high of Pp and of Ppk. Raises DataError where resamples show no spread."""

    def one(found: Floats, drawn: Floats) -> tuple[float, float, float]:
        good, here = drawn[np.isfinite(drawn)], float(found[0])
        if len(good) < 0.9 * len(drawn) or not math.isfinite(here):
            raise DataError("the readings are too much alike to show a shape: take --shape normal")
        return (here, *interval(here, good, level))

    pp = None
    if value[0] is not None and spread[0] is not None:
        pp = one(value[0], spread[0])
    return pp, one(value[1], spread[1])
