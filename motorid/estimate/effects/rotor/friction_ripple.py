"""Friction that varies with the rotor's angle: a rubbing disc, a bent shaft, a belt.

The shaft's friction has F cos(N angle + phase) more, against the motion whichever way it goes. One
way it cannot be told from cogging.
"""

from __future__ import annotations

from motorid.estimate.effects.action import AlongAngle
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use
from motorid.estimate.effects.rotor.cogging import friction
from motorid.estimate.effects.rotor.repeating import orders

FRICTION_RIPPLE = InfluenceQuantity(
    name="friction ripple",
    unit="N·m",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(AlongAngle(),),
    prior=lambda subject, place: Prior(friction(subject)),
    scale=friction,
    remedy="record more turns at each level, both ways",
    places=orders,
    listed=False,
)
