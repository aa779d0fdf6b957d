"""Friction that grows with the square of the speed: windage, a fan."""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)

LEAST = 1e-3  # of the stall torque: friction that counts


def _scale(subject: Subject) -> float:
    """The usual friction once more at the speed that the highest voltage would give."""
    if subject.judged_at is None:
        return 1.0
    R, _, K, B, _, T0 = (float(x) for x in subject.judged_at[:6])
    volts = float(np.abs(subject.volts).max()) or 1.0
    top = volts / K
    return max(T0 + B * top, LEAST * K * volts / R) / top**2


QUADRATIC_FRICTION = InfluenceQuantity(
    name="quadratic friction",
    unit="N·m·s²/rad²",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(MotorParameter("quadratic"),),
    prior=undeclared,
    scale=_scale,
    remedy="fit it: --model quadratic-load",
)
