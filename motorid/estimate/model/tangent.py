"""What one influence quantity does to the readings of a capture: the only derivative there is.

It serves the budget (times the quantity's uncertainty), the test whether the readings tell the
quantity, and the column of a fit that estimates it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]


def tangent(record: MotorRecord, shared: Floats, own: Floats, one: Instance) -> list[Floats]:
    """Change of every block's readings, (n,) each, for a unit of a quantity that is no unknown.

    Offsets and gains are linear in their size: any step is exact. What is simulated is taken by
    central differences, or to the side that the quantity's bounds leave.
    """
    quantity = one.quantity
    if not quantity.simulated:
        size = quantity.scale(record)
        return _slope(record, shared, own, one, 0.0, size)
    step = quantity.step * quantity.scale(record)
    lower, upper = quantity.bounds(record)
    return _slope(record, shared, own, one, max(-step, lower), min(step, upper))


def _slope(
    record: MotorRecord, shared: Floats, own: Floats, one: Instance, low: float, high: float
) -> list[Floats]:
    after = record.fitted(shared, own, {one: high})
    before = record.fitted(shared, own, {one: low} if low else {})
    return [(b - a) / (high - low) for a, b in zip(before, after, strict=True)]
