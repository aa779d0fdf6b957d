"""The relative rise of R over a capture, about its mean, as the winding warms.

    lost(t) = w R i (q/q_end − 1/2),    q = ∫i² dt

It bends speeds, and with them B and T0.
"""

from __future__ import annotations

from motorid.estimate.effects.brush_and_heating import WARMING, taken
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _prior(subject: Subject, place: int) -> Prior | None:
    loss = subject.loss
    if loss is None or WARMING not in loss.shapes:
        return None
    rise, spread = loss.rise
    return Prior(spread, mean=rise)


WINDING_WARMING = InfluenceQuantity(
    name=WARMING,
    unit="1",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(taken(WARMING),),
    prior=_prior,
    scale=lambda subject: 0.1,
    remedy="state the motor's thermal figures in the rig file's [thermal], or run shorter",
)
