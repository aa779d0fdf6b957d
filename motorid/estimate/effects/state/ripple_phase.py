"""The phase of commutation ripple at the start of a run, in a model that has it."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use

RIPPLE_PHASE = InfluenceQuantity(
    name="ripple phase",
    unit="rad",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(InitialState(5),),
    prior=lambda subject, place: Prior(),
    scale=scales.one,
    remedy="nothing: each run has an angle of its own",
)
