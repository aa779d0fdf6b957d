"""Kernels by which readings are smoothed digitally: around each reading, and behind it.

A moving mean around each reading, a Gaussian, a Savitzky-Golay filter, a low-pass run forwards and
backwards are done to a log afterwards. They are even, and a reading then shows an edge before it
comes, as behind no circuit. A recursive average and a mean of the last readings are done in
firmware as well. All kernels (2m + 1,) have a sum of one, with what comes later first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import comb

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Kernel = Callable[[float], Floats]

FARTHEST = 800  # readings on either side
LONG = 100  # beyond which spectra are faster
TRUNCATED = 4.0, 12.0  # of a Gaussian's standard deviation; of a low-pass's time constant


@dataclass(frozen=True)
class Smoothing:
    """``kernel`` of a size up to ``most``, ``wide`` in words; of ``whole`` sizes alone, or any.

    ``behind``: of readings that came before, which firmware can do: late by so many readings for
    each of its size.
    """

    how: str
    kernel: Kernel
    sizes: tuple[float, ...]  # that are tried
    wide: Callable[[float], str]
    whole: bool = False
    behind: float = 0.0
    most: float = FARTHEST


def moving_mean(size: float) -> Floats:
    """(2m + 1,); between two whole half-widths a mixture of both."""
    return _between(size, lambda m: np.full(2 * m + 1, 1.0 / (2 * m + 1)))


def savitzky_golay(size: float) -> Floats:
    """(2m + 1,), of second and third order (Savitzky and Golay, 1964); none below m = 2.

    Between two whole half-widths a mixture of both.
    """
    return _between(size, _quadratic)


def gaussian(size: float) -> Floats:
    """(2m + 1,), ``size`` being its standard deviation."""
    t = _around(TRUNCATED[0] * size)
    return _of_sum_one(np.exp(-0.5 * (t / max(size, 1e-3)) ** 2))


def both_ways(size: float) -> Floats:
    """(2m + 1,): a Butterworth low-pass of second order, forwards and backwards.

    ``size`` is √2 over its angular frequency: what |H|² = 1 / (1 + (ω/ω0)⁴) is in time.
    """
    t = np.abs(_around(TRUNCATED[1] * size)) / max(size, 1e-3)
    return _of_sum_one(np.exp(-t) * (np.cos(t) + np.sin(t)))


def recursive(size: float) -> Floats:
    """(2m + 1,): y += (x - y) / (1 + size), whose time constant is ``size`` readings and more."""
    size = max(size, 1e-3)
    back = _around(TRUNCATED[1] * (1.0 + size))
    return _of_sum_one(np.where(back >= 0.0, (size / (1.0 + size)) ** np.abs(back), 0.0))


def of_the_last(size: float) -> Floats:
    """(2m + 1,): the mean of a reading and of as many before it; between two a mixture of both."""
    return _between(size, lambda m: (_around(m) >= 0.0) / (m + 1.0))


def _quadratic(m: int) -> Floats:
    if m < 2:
        return np.ones(1)
    return _of_sum_one(3.0 * m * m + 3.0 * m - 1.0 - 5.0 * _around(m) ** 2)


def _between(size: float, whole: Callable[[int], Floats]) -> Floats:
    low = int(min(max(size, 0.0), FARTHEST - 1))
    small, large = whole(low), whole(low + 1)
    share = min(max(size - low, 0.0), 1.0)
    return share * large + (1.0 - share) * np.pad(small, (len(large) - len(small)) // 2)


def _around(reach: float) -> Floats:
    m = min(int(np.ceil(max(reach, 0.0))), FARTHEST)
    return np.arange(-m, m + 1, dtype=np.float64)


def _of_sum_one(kernel: Floats) -> Floats:
    return np.asarray(kernel / kernel.sum())


def smoothed(series: Floats, kernel: Floats) -> Floats:
    """A series (n,) behind a kernel (2m + 1,); the first and the last reading stand for more."""
    m = len(kernel) // 2
    padded = np.pad(series, m, mode="edge")
    if m <= LONG:
        return np.convolve(padded, kernel, mode="valid")
    count = len(padded)  # what wraps round falls on the first readings, which are padding
    product = np.fft.rfft(padded) * np.fft.rfft(kernel, count)
    return np.asarray(np.fft.irfft(product, count)[2 * m :])


def hidden(kernel: Floats, order: int) -> float:
    """How many times the variance of smoothed noise is what differences of that ``order`` show."""
    shown = (np.diff(np.pad(kernel, order), order) ** 2).sum() / comb(2 * order, order)
    return float((kernel**2).sum() / shown)


def _around_it(size: float) -> str:
    return f"{2.0 * size + 1.0:.2g} readings wide"


HALF_WIDTHS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
SMOOTHINGS = (
    Smoothing("a moving mean around each reading", moving_mean, HALF_WIDTHS, _around_it, True),
    Smoothing("a Savitzky-Golay filter", savitzky_golay, HALF_WIDTHS, _around_it, True),
    Smoothing("a Gaussian around each reading", gaussian, HALF_WIDTHS, _around_it),
    Smoothing("a low-pass forwards and backwards", both_ways, HALF_WIDTHS, _around_it),
    Smoothing(
        "a recursive average", recursive, (0.5, 2.0, 8.0, 32.0),
        lambda size: f"a new reading counts {1.0 / (1.0 + size):.2g}", behind=1.0,
        most=FARTHEST / TRUNCATED[1] - 1.0,
    ),
    Smoothing(
        "a mean of the last readings", of_the_last, (1.0, 3.0, 7.0, 31.0),
        lambda size: f"of {size + 1.0:.2g}", whole=True, behind=0.5,
    ),
)  # fmt: skip
