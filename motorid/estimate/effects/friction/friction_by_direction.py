"""Dry friction that is more one way than the other: brushes that are not in their neutral place.

    friction = T0 (1 + a s), s the direction

A run that turns one way shows the friction of that way alone.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Use,
    undeclared,
)

FRICTION_BY_DIRECTION = InfluenceQuantity(
    name="friction by direction",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(MotorParameter("asymmetry"),),
    prior=undeclared,
    scale=scales.one,
    remedy="fit it: --model direction",
)
