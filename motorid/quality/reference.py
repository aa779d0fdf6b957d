"""A gauge against a known motor: Cg and Cgk, bias, and linearity over several known motors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError
from motorid.quality.ranges import d2_star

Floats = NDArray[np.float64]
CAPABLE = 1.33  # what Cg and Cgk are asked to reach
SHARE, SPREAD = 0.2, 6.0  # of the tolerance; standard deviations


@dataclass(frozen=True)
class GoldenResult:
    """Repeated readings of one golden motor (a type-1 study).

    ``bias`` is mean less reference, ``interval_95`` its confidence interval with the reference's
    own uncertainty; ``p``: how likely so large a bias is where there is none. ``cg`` and ``cgk``
    are None without a tolerance.
    """

    count: int
    mean: float
    sigma: float
    reference: float
    reference_uncertainty: float
    bias: float
    interval_95: tuple[float, float]
    t: float
    p: float
    tolerance: float | None
    cg: float | None
    cgk: float | None

    @property
    def biased(self) -> bool:
        """The interval of the bias leaves out zero."""
        low, high = self.interval_95
        return not low <= 0 <= high


def golden(
    values: Floats,
    reference: float,
    *,
    tolerance: float | None = None,
    reference_uncertainty: float = 0.0,
    share: float = SHARE,
    spread: float = SPREAD,
) -> GoldenResult:
    """Cg, Cgk and bias of repeated readings ``values`` of a motor known to be ``reference``.

    ``share`` of the tolerance is what ``spread`` standard deviations of the gauge may fill.
    Raises DataError below two readings.
    """
    from scipy.stats import t as student

    n = len(values)
    if n < 2:
        raise DataError(f"a golden motor's study needs 2 readings or more (50 is usual), not {n}")
    if tolerance is not None and not tolerance > 0:
        raise UsageError(f"a tolerance is a positive width, not {tolerance}")
    mean, sigma = float(np.mean(values)), float(np.std(values, ddof=1))
    bias = mean - reference
    error = math.hypot(sigma / math.sqrt(n), reference_uncertainty)
    own = sigma / math.sqrt(n)
    degrees = (n - 1) * (error / own) ** 4 if own else math.inf  # Welch: the reference has many
    half = float(student.ppf(0.975, degrees)) * error
    t = bias / error if error else math.copysign(math.inf, bias) if bias else 0.0
    cg = cgk = None
    if tolerance is not None:
        cg = share * tolerance / (spread * sigma) if sigma else math.inf
        room = share / 2 * tolerance - abs(bias)
        cgk = room / (spread / 2 * sigma) if sigma else math.copysign(math.inf, room)
    return GoldenResult(
        n,
        mean,
        sigma,
        reference,
        reference_uncertainty,
        bias,
        (bias - half, bias + half),
        t,
        float(2 * student.sf(abs(t), degrees)),
        tolerance,
        cg,
        cgk,
    )


def sigma_by_range(values: Floats) -> float:
    """The standard deviation from the range of all readings, as the AIAG's older bias form asks."""
    return float(np.ptp(values)) / d2_star(len(values), 1)


@dataclass(frozen=True)
class Line:
    """One coefficient of the bias line, tested against zero."""

    value: float
    error: float
    t: float
    p: float


@dataclass(frozen=True)
class LinearityResult:
    """Bias against reference: ``bias = intercept + slope * reference``.

    ``biases``: (reference, mean bias) of each motor. ``r_squared`` of the line; ``sigma`` its
    residual standard deviation. ``band`` is (reference, low, high): the line's 95 % band.
    """

    count: int
    slope: Line
    intercept: Line
    r_squared: float
    sigma: float
    degrees: int
    biases: tuple[tuple[float, float], ...]
    band: tuple[tuple[float, float, float], ...]

    @property
    def acceptable(self) -> bool:
        """AIAG: zero bias lies within the line's band at every motor that was measured."""
        at = {x for x, _ in self.biases}
        return all(low <= 0 <= high for x, low, high in self.band if x in at)


def linearity(references: Sequence[float], values: Sequence[Floats]) -> LinearityResult:
    """The line of bias over several motors whose references are known (AIAG).

    Raises DataError below three different references or where a motor has no reading.
    """
    from scipy.stats import t as student

    if len(set(references)) < 3:
        raise DataError(
            f"linearity needs motors of three different references or more, not "
            f"{len(set(references))}"
        )
    if any(len(v) == 0 for v in values):
        raise DataError("linearity needs readings of every motor")
    x = np.repeat(np.asarray(references, float), [len(v) for v in values])
    y = np.concatenate([np.asarray(v, float) - r for r, v in zip(references, values, strict=True)])
    n, centre = len(x), float(x.mean())
    sxx = float(np.sum((x - centre) ** 2))
    slope = float(np.sum((x - centre) * y)) / sxx
    intercept = float(y.mean()) - slope * centre
    residual = y - intercept - slope * x
    sigma = math.sqrt(float(residual @ residual) / (n - 2))
    total = float(np.sum((y - y.mean()) ** 2))

    def line(value: float, error: float) -> Line:
        t = value / error if error else math.inf
        return Line(value, error, t, float(2 * student.sf(abs(t), n - 2)))

    at = np.union1d(np.asarray(references, float), np.linspace(x.min(), x.max(), 41))
    half = student.ppf(0.975, n - 2) * sigma * np.sqrt(1 / n + (at - centre) ** 2 / sxx)
    fitted = intercept + slope * at
    band = zip(at.tolist(), (fitted - half).tolist(), (fitted + half).tolist(), strict=True)
    return LinearityResult(
        n,
        line(slope, sigma / math.sqrt(sxx)),
        line(intercept, sigma * math.sqrt(1 / n + centre**2 / sxx)),
        1 - float(residual @ residual) / total if total else 1.0,
        sigma,
        n - 2,
        tuple((float(r), float(np.mean(v) - r)) for r, v in zip(references, values, strict=True)),
        tuple(band),
    )
