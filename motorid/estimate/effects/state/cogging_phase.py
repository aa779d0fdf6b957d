"""The phase of cogging at the start of a run, in a model that has cogging."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use

COGGING_PHASE = InfluenceQuantity(
    name="cogging phase",
    unit="rad",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(InitialState(4),),
    prior=lambda subject, place: Prior(),
    scale=scales.one,
    remedy="nothing: each run has an angle of its own",
)
