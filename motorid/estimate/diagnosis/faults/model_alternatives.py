"""What the six-parameter model lacks without any fault of the chain: explained, not suspected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.estimate.diagnosis.fault import (
    Effect,
    Hypothesis,
    Words,
    added_voltage,
    current_of,
    nothing,
    series,
)
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

BRUSH_SHARE = 0.05  # of the largest current, at which half of a brush drop is there


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """A winding that warms up, a brush drop, friction that bends with speed."""
    volts = max(float(np.abs(r.volts).max()) for r in records)
    return [
        _guard("winding_warms", _warming, 0.05, 0.2),
        _guard("brush_drop", _brush, 0.02 * volts, 0.1 * volts),
        _guard("friction_bends", _bent_friction, 0.1, 2.0),
    ]


def _guard(code: str, effect: Effect, size: float, most: float) -> Hypothesis:
    return Hypothesis(
        code, effect, ((size,),), (size,), (-most,), (most,),
        lambda size: Words("motor", "", ""), guard=True,
    )  # fmt: skip


def _warming(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """R grows by ``size`` of itself over the run, as the heat i² adds up."""
    current = current_of(record, values, own)
    if current is None:
        return nothing(record)
    heat = np.cumsum(current**2)
    R = float(record.motor(values)[0])
    return added_voltage(record, values, own, -R * size[0] * current * heat / max(heat[-1], 1e-300))


def _brush(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """``size`` volts against the current's direction."""
    current = current_of(record, values, own)
    if current is None:
        return nothing(record)
    soft = BRUSH_SHARE * float(np.abs(current).max())
    return added_voltage(record, values, own, -size[0] * current / np.hypot(current, soft))


def _bent_friction(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """Torque that grows with the square of the speed: ``size`` of the Coulomb torque at the top."""
    R, _, K, _, _, T0 = (float(v) for v in record.motor(values)[:6])
    current = current_of(record, values, own)
    if current is None:
        return nothing(record)
    speed = np.where(record.driven, (record.volts - R * current) / K, 0.0)
    top = float(np.abs(speed).max()) or 1.0
    torque = -size[0] * T0 * speed * np.abs(speed) / top**2
    out = added_voltage(record, values, own, R * torque / K)
    for k, _y in series(record, values, own, CURRENT):
        out[k] = out[k] - (torque / K)[record.measured[k].where]
    return out
