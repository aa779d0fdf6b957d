"""Autoregressive models of residuals: order by Schwarz's criterion, spectrum, whitening filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import dot, square
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]

FREQUENCIES = 512
LARGEST_ORDER = 12  # of the autoregressive spectrum
COLOURED = 2.0  # top of a spectrum over its mean that is worth whitening


def whitener(*residuals: Floats) -> Floats | None:
    """The filter 1, -c1, -c2 .. that leaves ``residuals`` white; None when they are near enough."""
    coefficients, innovation = autoregression(*residuals)
    if not len(coefficients):
        return None
    spectrum = power(coefficients, innovation, FREQUENCIES)
    if float(spectrum.max()) < COLOURED * float(spectrum.mean()):
        return None
    return np.concatenate([[1.0], -coefficients])


def prominence(residual: Floats) -> float:
    """Top of a residual's spectrum over its mean, at least 1: readings that count as one."""
    coefficients, innovation = autoregression(residual)
    if not len(coefficients):
        return 1.0
    spectrum = power(coefficients, innovation, FREQUENCIES)
    return max(1.0, float(spectrum.max() / spectrum.mean()))


def inflation(solution: Solution) -> float:
    """The most prominent frequency of what is left of any block: readings that count as one."""
    return max(
        (prominence(line.residual[part]) for line in solution.records for part in line.slices),
        default=1.0,
    )


def fast_length(least: int) -> int:
    """A length that the FFT likes."""
    return 1 << (least - 1).bit_length()


def power(coefficients: Floats, innovation: float, size: int) -> Floats:
    """Spectrum of an autoregressive process at rfft frequencies; its mean is the variance."""
    polynomial = np.concatenate([[1.0], -coefficients])
    return np.asarray(innovation / np.abs(np.fft.rfft(polynomial, size)) ** 2)


def autoregression(*residuals: Floats) -> tuple[Floats, float]:
    """Coefficients and innovation variance of r[t] = sum c[k] r[t-k] + e[t], order by BIC.

    Several stretches of one process are taken together.
    """
    n = sum(len(r) for r in residuals)
    largest = min(LARGEST_ORDER, min(len(r) for r in residuals) // 8)
    if largest < 1:
        return np.zeros(0), sum(square(r) for r in residuals) / max(n, 1)
    lags = np.sum([len(r) * autocovariance(r, largest) for r in residuals], axis=0) / n
    best, chosen, variance = np.inf, np.zeros(0), float(lags[0])
    current, innovation = np.zeros(0), float(lags[0])
    for order in range(largest + 1):
        if order:
            current, innovation = _levinson(current, innovation, lags)
        if innovation <= 0:
            break
        criterion = n * float(np.log(innovation)) + order * float(np.log(n))
        if criterion < best:
            best, chosen, variance = criterion, current, innovation
    return chosen, variance


def autocovariance(residual: Floats, largest: int) -> Floats:
    """Biased sample autocovariance about zero, lags 0 to ``largest``."""
    n = len(residual)
    return np.array([dot(residual[: n - k], residual[k:]) / n for k in range(largest + 1)])


def _levinson(coefficients: Floats, innovation: float, lags: Floats) -> tuple[Floats, float]:
    """One order more of the Yule-Walker solution."""
    order = len(coefficients)
    reflection = (lags[order + 1] - coefficients @ lags[order:0:-1]) / innovation
    longer = np.append(coefficients - reflection * coefficients[::-1], reflection)
    return longer, float(innovation * (1.0 - reflection**2))
