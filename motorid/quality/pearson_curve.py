"""Pearson's curves: the distribution of a given mean, standard deviation, skewness and kurtosis.

    p'/p = -(x + c1) / (c0 + c1 x + c2 x²)      in standard deviations from the mean

(Pearson 1895; Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions, 12.4.) By the
sign of c2 and of the discriminant it is a beta, a gamma, a beta prime, or Pearson's type IV.
Clements (1989) takes the percentiles of a skewed process from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
NEAR_GAMMA = 1e-6  # of c2: nearer to zero, the curve is a gamma to the last digit that matters
NEAR_NORMAL = 1e-5  # of the skewness: a gamma of a larger shape is normal
LEAST_ROOM = 1e-6  # of kurtosis over its least value, skewness² - 2, which two points alone reach
FARTHEST, STEPS = 100.0, 4001  # of the grid of type IV, in standard deviations


@dataclass(frozen=True)
class PearsonCurve:
    """One curve, or many: every field is of shape (k,). ``kurtosis`` is 0 for a normal one.

    A kurtosis that no distribution of that skewness has is raised to the least one.
    """

    mean: Floats
    sd: Floats
    skewness: Floats
    kurtosis: Floats

    def quantile(self, probability: float) -> Floats:
        """The value (k,) below which that share lies."""
        return self.mean + self.sd * self._standard(probability)

    def cdf(self, x: float) -> float:
        """The share below ``x``; of a single curve."""
        z = (x - float(self.mean[0])) / float(self.sd[0])
        skew, kurtosis = _possible(self.skewness, self.kurtosis)
        below = _cdf(z if skew[0] >= 0.0 else -z, abs(float(skew[0])), float(kurtosis[0]))
        return below if skew[0] >= 0.0 else 1.0 - below

    def _standard(self, probability: float) -> Floats:
        skew, kurtosis = _possible(self.skewness, self.kurtosis)
        found = np.empty(len(skew))
        for mirrored in (False, True):
            here = (skew < 0.0) == mirrored
            if here.any():
                p = 1.0 - probability if mirrored else probability
                z = _quantile(p, np.abs(skew[here]), kurtosis[here])
                found[here] = -z if mirrored else z
        return found


def curve_of(values: Floats) -> PearsonCurve:
    """The curve of the moments of ``values`` (n,): those of a sample, as spreadsheets give them."""
    n, mean = len(values), float(values.mean())
    second, third, fourth = (float(((values - mean) ** k).mean()) for k in (2, 3, 4))
    skew = np.divide(third, second**1.5)
    kurtosis = np.divide(fourth, second**2) - 3.0
    if n > 2:
        skew = math.sqrt(n * (n - 1.0)) / (n - 2.0) * skew
    if n > 3:
        kurtosis = (n - 1.0) / ((n - 2.0) * (n - 3.0)) * ((n + 1.0) * kurtosis + 6.0)
    sd = float(values.std(ddof=1))
    return PearsonCurve(np.array([mean]), np.array([sd]), np.array([skew]), np.array([kurtosis]))


def _possible(skew: Floats, kurtosis: Floats) -> tuple[Floats, Floats]:
    return skew, np.maximum(kurtosis, skew**2 - 2.0 + LEAST_ROOM)


def _coefficients(skew: Floats, kurtosis: Floats) -> tuple[Floats, Floats, Floats]:
    """c0, c1 and c2 where 2 kurtosis >= 3 skewness², so that their divisor is positive."""
    b1, b2 = skew**2, kurtosis + 3.0
    over = 10.0 * b2 - 12.0 * b1 - 18.0
    return (
        (4.0 * b2 - 3.0 * b1) / over,
        skew * (b2 + 3.0) / over,
        (2.0 * b2 - 3.0 * b1 - 6.0) / over,
    )


def _kinds(skew: Floats, kurtosis: Floats) -> dict[str, NDArray[np.bool_]]:
    """Which curve is which, for skewness of zero or more."""
    beyond = 2.0 * kurtosis - 3.0 * skew**2
    gamma = np.abs(beyond) < NEAR_GAMMA * 12.0
    beta = (beyond < 0.0) & ~gamma
    heavy = ~(gamma | beta)
    c0, c1, c2 = (np.zeros_like(skew) for _ in range(3))
    if heavy.any():
        c0[heavy], c1[heavy], c2[heavy] = _coefficients(skew[heavy], kurtosis[heavy])
    four = heavy & (c1**2 < 4.0 * c0 * c2)
    normal = gamma & (skew < NEAR_NORMAL)
    return {
        "normal": normal, "gamma": gamma & ~normal, "beta": beta, "four": four,
        "beta prime": heavy & ~four,
    }  # fmt: skip


def _quantile(p: float, skew: Floats, kurtosis: Floats) -> Floats:
    """Standardized quantiles for skewness of zero or more."""
    from scipy.special import betaincinv, gammaincinv, ndtri

    found = np.empty(len(skew))
    for kind, here in _kinds(skew, kurtosis).items():
        if not here.any():
            continue
        s, k = skew[here], kurtosis[here]
        if kind == "normal":
            found[here] = ndtri(p)
        elif kind == "gamma":
            shape = 4.0 / s**2
            found[here] = (gammaincinv(shape, p) - shape) / np.sqrt(shape)
        elif kind == "beta":
            a, b, centre, sd = _beta(s, k)
            found[here] = (betaincinv(a, b, p) - centre) / sd
        elif kind == "beta prime":
            a, b, foot, width = _beta_prime(s, k)
            z = betaincinv(a, b, p)
            found[here] = foot + width * z / (1.0 - z)
        else:
            found[here] = [float(np.interp(p, below, x)) for x, below in _four(s, k)]
    return found


def _cdf(z: float, skew: float, kurtosis: float) -> float:
    """Of one standardized curve, for skewness of zero or more."""
    from scipy.special import betainc, gammainc, ndtr

    s, k = np.array([skew]), np.array([kurtosis])
    kind = next(name for name, here in _kinds(s, k).items() if here[0])
    if kind == "normal":
        return float(ndtr(z))
    if kind == "gamma":
        shape = 4.0 / skew**2
        return float(gammainc(shape, max(0.0, shape + z * shape**0.5)))
    if kind == "beta":
        a, b, centre, sd = (float(v[0]) for v in _beta(s, k))
        return float(betainc(a, b, min(1.0, max(0.0, centre + z * sd))))
    if kind == "beta prime":
        a, b, foot, width = (float(v[0]) for v in _beta_prime(s, k))
        y = max(0.0, (z - foot) / width)
        return float(betainc(a, b, y / (1.0 + y)))
    x, below = _four(s, k)[0]
    return float(np.interp(z, x, below))


def _beta(skew: Floats, kurtosis: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Type I: both exponents, mean and standard deviation on 0 to 1; skewness of zero or more."""
    b1 = skew**2
    r = 6.0 * (kurtosis + 2.0 - b1) / (3.0 * b1 - 2.0 * kurtosis)
    tilt = (r + 2.0) * np.sqrt(b1 / (b1 * (r + 2.0) ** 2 + 16.0 * (r + 1.0)))
    a, b = 0.5 * r * (1.0 - tilt), 0.5 * r * (1.0 + tilt)
    return a, b, a / r, np.sqrt(a * b / (r + 1.0)) / r


def _beta_prime(skew: Floats, kurtosis: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Type VI: both exponents, where it begins, and the distance of the roots."""
    c0, c1, c2 = _coefficients(skew, kurtosis)
    root = np.sqrt(np.maximum(c1**2 - 4.0 * c0 * c2, 1e-18 * c1**2))
    low, high = (-c1 - root) / (2.0 * c2), (-c1 + root) / (2.0 * c2)
    width = high - low
    m_low, m_high = (c1 + low) / (c2 * width), -(c1 + high) / (c2 * width)
    return m_high + 1.0, -m_low - m_high - 1.0, high, width


def _four(skew: Floats, kurtosis: Floats) -> list[tuple[Floats, Floats]]:
    """Type IV: a grid and the share below each of its points, for each curve."""
    c0, c1, c2 = (c[:, None] for c in _coefficients(skew, kurtosis))
    reach = np.arcsinh(FARTHEST)
    t = np.linspace(-reach, reach, STEPS)
    x = np.sinh(t)
    centre = -c1 / (2.0 * c2)
    width = np.sqrt(np.maximum(c0 / c2 - centre**2, 1e-12))
    away = x - centre
    log = -np.log(away**2 + width**2) / (2.0 * c2)
    log -= (c1 + centre) / (c2 * width) * np.arctan(away / width)
    density = np.exp(log - log.max(axis=1, keepdims=True)) * np.cosh(t)
    area = 0.5 * (density[:, 1:] + density[:, :-1])
    below = np.concatenate([np.zeros((len(skew), 1)), np.cumsum(area, axis=1)], axis=1)
    below /= below[:, -1:]
    return [(x, row) for row in below]
