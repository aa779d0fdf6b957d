"""Readings of a log that were smoothed afterwards, with as much of what follows as of what was.

A moving mean around each reading, a Gaussian, a Savitzky-Golay filter, a low-pass run forwards and
backwards: no circuit does it, since a reading then shows an edge before it comes. All kernels are
even and their sum is one; ``size`` is a half-width in readings.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import comb

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.effects.action import Reading
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Instance,
    Scope,
    Use,
    undeclared,
)
from motorid.estimate.solver.problem import Unknown

Floats = NDArray[np.float64]
Kernel = Callable[[float], Floats]

FARTHEST = 200  # readings on either side
TRUNCATED = 4.0, 12.0  # of a Gaussian's standard deviation; of a low-pass's time constant


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
    return np.convolve(np.pad(series, m, mode="edge"), kernel, mode="valid")


def _shown(kernel: Kernel) -> Callable[[Floats, Floats | float], Floats]:
    return lambda series, size: smoothed(series, kernel(float(size))) if size else series


KERNELS: dict[str, Kernel] = {
    "a moving mean around each reading": moving_mean,
    "a Savitzky-Golay filter": savitzky_golay,
    "a Gaussian around each reading": gaussian,
    "a low-pass forwards and backwards": both_ways,
}
WHOLE = (moving_mean, savitzky_golay)  # of whole half-widths; what lies between serves a search


def _quantity(channel: str, how: str, kernel: Kernel) -> InfluenceQuantity:
    return InfluenceQuantity(
        name=f"{channel} behind {how}",
        unit="readings",
        scope=Scope.MOTOR,
        use=Use.TESTED,
        acts=(Reading(channel, _shown(kernel)),),
        prior=undeclared,
        scale=lambda subject: 1.0,
        remedy=f"fit the {channel} as it was recorded, before any smoothing",
        bounds=lambda subject: (0.0, float(FARTHEST)),
    )


SMOOTHING_AROUND: dict[str, dict[str, InfluenceQuantity]] = {
    channel: {how: _quantity(channel, how, kernel) for how, kernel in KERNELS.items()}
    for channel in (CURRENT, SPEED)
}


_KERNEL = {
    quantity: (channel, KERNELS[how])
    for channel, kinds in SMOOTHING_AROUND.items()
    for how, quantity in kinds.items()
}


def hidden_noise(
    instances: Sequence[Instance], unknowns: Sequence[Unknown], block: str, order: int = 1
) -> float:
    """How many times the variance of noise in a block's readings is what differences of that
    ``order`` show of it, where one of a capture's unknowns smoothed them; 1: as of white noise.
    """
    for one, unknown in zip(instances, unknowns, strict=True):
        channel, kernel = _KERNEL.get(one.quantity, ("", moving_mean))
        if channel == block and unknown.start:
            h = kernel(unknown.start)
            shown = (np.diff(np.pad(h, order), order) ** 2).sum() / comb(2 * order, order)
            return float((h**2).sum() / shown)
    return 1.0
