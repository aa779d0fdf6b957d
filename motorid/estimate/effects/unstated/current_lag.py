"""By how much the current's readings of a log come later than its motion's, stamp for stamp."""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Delay
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.unstated import default

CURRENT_LAG = InfluenceQuantity(
    name="current lag",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(Delay(CURRENT),),
    prior=default.of(CURRENT, "delay"),
    scale=scales.period_s,
    remedy="stamp all channels by one clock, or declare their delays (--delay)",
    bounds=default.either_way,
    step=2e-4,
)
