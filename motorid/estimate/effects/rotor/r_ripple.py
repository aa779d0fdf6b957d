"""The ripple of R with the rotor's angle: brushes that bridge one bar more or less.

R is R (1 + k cos(N angle + phase)).
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import AlongAngle
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use
from motorid.estimate.effects.rotor.k_ripple import USUAL
from motorid.estimate.effects.rotor.repeating import orders

R_RIPPLE = InfluenceQuantity(
    name="ripple of R",
    unit="1",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(AlongAngle(),),
    prior=lambda subject, place: Prior(USUAL),
    scale=scales.one,
    remedy="record more turns at each level: every commutator ripples",
    places=orders,
    listed=False,
)
