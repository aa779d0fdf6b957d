"""A low-pass filter in the channel of a log's voltage, of which nobody says anything.

    voltage at the motor = v + tau dv/dt

of the reading v behind a filter of the first order. Between two samples the mean of that slope is
no noisier than the readings are.
"""

from __future__ import annotations

from motorid.capture.model import VOLTAGE
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import LogFilter
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

VOLTAGE_SMOOTHING = InfluenceQuantity(
    name="voltage smoothing",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(LogFilter(),),
    prior=default.of(VOLTAGE, "filter"),
    scale=scales.period_s,
    remedy="declare the filter of the voltage's channel (--filter), or take it out",
    bounds=default.smoothing,
)
