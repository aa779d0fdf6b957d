"""The gain of the current's channel, which leaves no residual: R, L, B, J and T0 scale with it."""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, times
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use

CURRENT_GAIN = InfluenceQuantity(
    name="current gain",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Reading(CURRENT, times),),
    prior=scales.declared(CURRENT, "gain_uncertainty"),
    scale=scales.one,
    remedy="calibrate the current's gain (motorid calibrate)",
)
