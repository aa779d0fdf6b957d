"""The second order of a low-pass in the channel of a log's current, of which nobody says anything.

    1/(1 + a s + b² s²)

with the current smoothing a. It is looked for only where such a filter of first order was found.
"""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import SecondOrderLowPass
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

CURRENT_SECOND_ORDER = InfluenceQuantity(
    name="current smoothing of second order",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(SecondOrderLowPass(CURRENT),),
    prior=default.of(CURRENT, "filter"),
    scale=scales.period_s,
    remedy="declare the filter of the current's channel (--filter), or take it out",
    bounds=default.none_or_more,
)
