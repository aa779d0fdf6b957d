"""The drop of brushes and bridge times the logarithm by which its knee is off the usual one.

lost(t) = W ds/d ln b
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.brush_and_heating import BENT, taken
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

BENDING = 1 / 3  # of the drop's size: deviation before any current is known
WIDEST = 0.03  # of the brushes' voltage: no drop times the logarithm of its bend is more


def _prior(subject: Subject, place: int) -> Prior | None:
    loss = subject.loss
    if loss is None or BENT not in loss.shapes:
        return None
    if subject.judged_at is None:
        return Prior(BENDING * loss.expected)
    sd, mean = loss.bending(subject.losing)
    return Prior(sd, mean=mean)


def _bounds(subject: Subject) -> tuple[float, float]:
    loss = subject.loss
    return (0.0, 0.0) if loss is None else (-WIDEST * loss.brushes_v, WIDEST * loss.brushes_v)


BRUSH_BEND = InfluenceQuantity(
    name=BENT,
    unit="V",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(taken(BENT),),
    prior=_prior,
    scale=scales.top_volts,
    remedy="declare the drop (brush_drop_v of the rig), or add a level",
    bounds=_bounds,
    listed=False,
)
