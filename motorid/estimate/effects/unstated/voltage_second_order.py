"""The second order of a low-pass in the channel of a log's voltage, of which nobody says anything.

    1/(1 + a s + b² s²)

with the voltage smoothing a. It is looked for only where such a filter of first order was found.
"""

from __future__ import annotations

from motorid.capture.model import VOLTAGE
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import LogSecondOrder
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

VOLTAGE_SECOND_ORDER = InfluenceQuantity(
    name="voltage smoothing of second order",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(LogSecondOrder(),),
    prior=default.of(VOLTAGE, "filter"),
    scale=scales.period_s,
    remedy="declare the filter of the voltage's channel (--filter), or take it out",
    bounds=default.none_or_more,
)
