"""The ripple of K with the rotor's angle: commutation, slots, and bars that differ.

K is K (1 + k cos(N angle + phase)), for back-EMF and torque alike.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import AlongAngle
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use
from motorid.estimate.effects.rotor.repeating import orders

USUAL = 0.1  # of three bars, that ripple most: standard

K_RIPPLE = InfluenceQuantity(
    name="ripple of K",
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
