"""A low-pass filter in the channel of a log's speed, or the smoothing of what computes it."""

from __future__ import annotations

from motorid.capture.model import SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import LowPass
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

SPEED_SMOOTHING = InfluenceQuantity(
    name="speed smoothing",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(LowPass(SPEED),),
    prior=default.of(SPEED, "filter"),
    scale=scales.period_s,
    remedy="declare the filter of the speed's channel (--filter), or take it out",
    bounds=default.smoothing,
)
