"""Readings of the current or the speed that were smoothed digitally, in firmware or afterwards."""

from __future__ import annotations

from collections.abc import Callable, Sequence

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
from motorid.estimate.effects.reading.smoothing_kernels import (
    SMOOTHINGS,
    Kernel,
    Smoothing,
    hidden,
    smoothed,
)
from motorid.estimate.solver.problem import Unknown

Floats = NDArray[np.float64]


def _shown(kernel: Kernel) -> Callable[[Floats, Floats | float], Floats]:
    return lambda series, size: smoothed(series, kernel(float(size))) if size else series


def _quantity(channel: str, way: Smoothing) -> InfluenceQuantity:
    return InfluenceQuantity(
        name=f"{channel} behind {way.how}",
        unit="readings",
        scope=Scope.MOTOR,
        use=Use.TESTED,
        acts=(Reading(channel, _shown(way.kernel)),),
        prior=undeclared,
        scale=lambda subject: 1.0,
        remedy=f"fit the {channel} as it was recorded, before any smoothing",
        bounds=lambda subject: (0.0, way.most),
    )


SMOOTHED: dict[str, dict[Smoothing, InfluenceQuantity]] = {
    channel: {way: _quantity(channel, way) for way in SMOOTHINGS} for channel in (CURRENT, SPEED)
}


def delaying(quantity: InfluenceQuantity, way: Smoothing, readings: float) -> Unknown:
    """One that is there, late by so many readings (> 0)."""
    size = min(readings / way.behind, way.most)
    return Unknown(quantity.name, size, 0.0, way.most, scale=1.0, prior_sd=size)


_KERNEL = {
    quantity: (channel, way.kernel)
    for channel, ways in SMOOTHED.items()
    for way, quantity in ways.items()
}


def smoothed_by(
    instances: Sequence[Instance], unknowns: Sequence[Unknown], block: str
) -> Floats | None:
    """The kernel (2m + 1,) by which one of a capture's unknowns smoothed a block; None: none."""
    for one, unknown in zip(instances, unknowns, strict=True):
        channel, kernel = _KERNEL.get(one.quantity, ("", None))
        if kernel is not None and channel == block and unknown.start:
            return kernel(unknown.start)
    return None


def hidden_noise(
    instances: Sequence[Instance], unknowns: Sequence[Unknown], block: str, order: int = 1
) -> float:
    """How many times the variance of noise in a block's readings is what differences of that
    ``order`` show of it, where one of a capture's unknowns smoothed them; 1: as of white noise.
    """
    kernel = smoothed_by(instances, unknowns, block)
    return 1.0 if kernel is None else hidden(kernel, order)
