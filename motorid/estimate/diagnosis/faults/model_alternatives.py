"""What the six-parameter model lacks without any fault of the chain: explained, not suspected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.fault import (
    Effect,
    Hypothesis,
    Words,
    acting,
    added_voltage,
    current_of,
    nothing,
)
from motorid.estimate.effects.brush_and_heating import BEND, DROP, WARMING
from motorid.estimate.effects.friction.friction_by_direction import FRICTION_BY_DIRECTION
from motorid.estimate.effects.friction.friction_drift import FRICTION_DRIFT
from motorid.estimate.effects.friction.load_friction import LOAD_FRICTION
from motorid.estimate.effects.friction.quadratic_friction import QUADRATIC_FRICTION
from motorid.estimate.effects.iron.armature_reaction import ARMATURE_REACTION
from motorid.estimate.effects.iron.eddy_currents import EDDY_CURRENTS
from motorid.estimate.effects.iron.saturation import SATURATION
from motorid.estimate.effects.source.brush_drop import BRUSH_DROP
from motorid.estimate.effects.source.commutation_resistance import COMMUTATION_RESISTANCE
from motorid.estimate.effects.source.winding_warming import WINDING_WARMING
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """A winding that warms up, a brush drop, friction that bends with speed, with the direction or
    with the load, or changes with time, R that rises with speed, K and L that fall with the
    current, currents in iron.
    """
    volts = max(float(np.abs(r.volts).max()) for r in records)
    bend = min(QUADRATIC_FRICTION.scale(r) for r in records)
    return [
        _guard("winding_warms", _warming, 0.05, 0.2),
        _guard("brush_drop", brush_drop, 0.02 * volts, 0.1 * volts),
        _guard("friction_bends", acting(QUADRATIC_FRICTION), 0.1 * bend, 2.0 * bend),
        _guard("friction_by_direction", acting(FRICTION_BY_DIRECTION), 0.05, 0.9),
        _guard("load_friction", acting(LOAD_FRICTION), 0.01, 0.3, 0.0),
        *_of_fitted(records),
    ]


def _of_fitted(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """Whose sizes hang on the motor's stall current or speed: of records that were fitted."""
    if any(r.judged_at is None for r in records):
        return []
    reaction = min(ARMATURE_REACTION.scale(r) for r in records)
    rise = min(COMMUTATION_RESISTANCE.scale(r) for r in records)
    friction = min(FRICTION_DRIFT.scale(r) for r in records)
    return [
        _guard("commutation_resistance", acting(COMMUTATION_RESISTANCE), 0.01 * rise, rise, 0.0),
        _guard("friction_drifts", acting(FRICTION_DRIFT), 0.1 * friction, friction),
        _guard("armature_reaction", acting(ARMATURE_REACTION), 0.01 * reaction, reaction, 0.0),
        _guard("saturation", acting(SATURATION), 0.1, 0.9, 0.0),
        _guard("eddy_currents", acting(EDDY_CURRENTS), 0.1, 0.9, 0.0),
    ]


def _guard(
    code: str, effect: Effect, size: float, most: float, least: float | None = None
) -> Hypothesis:
    lower = -most if least is None else least
    return Hypothesis(
        code, effect, ((size,),), (size,), (lower,), (most,),
        lambda size: Words("motor", "", ""), guard=True,
    )  # fmt: skip


def _warming(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """R grows by ``size`` of itself over the run, as the heat i² adds up."""
    if record.loss is not None and WARMING in record.loss.shapes:
        return acting(WINDING_WARMING)(record, values, own, size)
    current = current_of(record, values, own)
    if current is None:
        return nothing(record)
    heat = np.cumsum(current**2)
    R = float(record.motor(values)[0])
    return added_voltage(record, values, own, -R * size[0] * current * heat / max(heat[-1], 1e-300))


def brush_drop(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    """``size`` volts against the current's direction."""
    if record.loss is not None and DROP in record.loss.shapes:
        return acting(BRUSH_DROP)(record, values, own, size)
    current = current_of(record, values, own)
    if current is None:
        return nothing(record)
    soft = BEND * float(np.abs(record.volts).max() / record.motor(values)[0])
    return added_voltage(record, values, own, -size[0] * current / np.hypot(current, soft))
