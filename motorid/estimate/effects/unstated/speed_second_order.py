"""The second order of a low-pass in the channel of a log's speed, of which nobody says anything.

    1/(1 + a s + b² s²)

with the speed smoothing a. It is looked for only where such a filter of first order was found.
"""

from __future__ import annotations

from motorid.capture.model import SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import SecondOrderLowPass
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

SPEED_SECOND_ORDER = InfluenceQuantity(
    name="speed smoothing of second order",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(SecondOrderLowPass(SPEED),),
    prior=default.of(SPEED, "filter"),
    scale=scales.period_s,
    remedy="declare the filter of the speed's channel (--filter), or take it out",
    bounds=default.none_or_more,
)
