"""The relative rise of R at the start of a run, in a model whose winding warms."""

from __future__ import annotations

from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use

WARMTH_SD = 0.1  # of R, by which a run may begin warmer than the first

INITIAL_WARMTH = InfluenceQuantity(
    name="initial warmth",
    unit="1",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(InitialState(3),),
    prior=lambda subject, place: Prior(WARMTH_SD),
    scale=lambda _: 0.01,
    remedy="let the motor cool between runs",
)
