"""The measured speed at every tick, for effects that follow the shaft and not the model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

HALF = 16  # samples on either side over which a position's slope is taken


def measured_speed(record: MotorRecord, half: int = HALF) -> Floats | None:
    """rad/s at the motor's shaft, smoothed, (count,); None where no motion was measured."""
    moving = next((m for m in record.measured if m.block.name in (POSITION, SPEED)), None)
    if moving is None:
        return None
    place = np.arange(record.timeline.count)
    y = np.interp(place, moving.keep, moving.values)
    if moving.block.name == SPEED:
        y = np.concatenate([[0.0], np.cumsum(y)[:-1]]) * record.timeline.period_s
    low, high = np.maximum(place - half, 0), np.minimum(place + half, len(y) - 1)
    return np.asarray((y[high] - y[low]) / ((high - low) * record.timeline.period_s))
