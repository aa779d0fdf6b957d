"""A low-pass filter in the channel of a log's current, of which nobody says anything."""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import LowPass
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

CURRENT_SMOOTHING = InfluenceQuantity(
    name="current smoothing",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(LowPass(CURRENT),),
    prior=default.of(CURRENT, "filter"),
    scale=scales.period_s,
    remedy="declare the filter of the current's channel (--filter), or take it out",
    bounds=default.smoothing,
)
