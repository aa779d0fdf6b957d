"""The encoder's error that repeats with its turn, as of a disc that is not centred on its shaft."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import AlongAngle
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use
from motorid.estimate.effects.rotor.repeating import orders

USUAL_RAD = 0.02  # of a disc of 10 mm radius, 0.2 mm off its centre: standard

ENCODER_ERROR = InfluenceQuantity(
    name="encoder error",
    unit="rad",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(AlongAngle(),),
    prior=lambda subject, place: Prior(USUAL_RAD),
    scale=scales.one,
    remedy="centre the encoder's disc, or record more turns at each level",
    places=orders,
    listed=False,
)
