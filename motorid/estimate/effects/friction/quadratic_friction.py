"""Friction that grows with the square of the speed: windage, a fan."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)


def _scale(subject: Subject) -> float:
    """The usual friction once more at the speed that the highest voltage would give."""
    if subject.judged_at is None:
        return 1.0
    return scales.friction(subject) / scales.top_speed(subject) ** 2


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
