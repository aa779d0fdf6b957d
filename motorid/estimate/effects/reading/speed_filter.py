"""A low-pass filter in the channel of a measured speed, or the smoothing of what computes it."""

from __future__ import annotations

from motorid.capture.model import SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import LowPass
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use, undeclared

SPEED_FILTER = InfluenceQuantity(
    name="speed filter",
    unit="s",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(LowPass(SPEED),),
    prior=undeclared,
    scale=scales.period_s,
    remedy="take the filter out of the speed's channel, or correct the readings for it",
    bounds=lambda subject: (0.0, float("inf")),
)
