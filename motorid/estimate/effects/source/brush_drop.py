"""The voltage drop of both brushes, which hardly grows with the current.

    lost(t) = V s,    s = i / sqrt(i² + b²)

Taken for a resistance it makes R too large, and K with it.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.brush_and_heating import DROP, taken
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

LEAST, MOST = -0.01, 0.3  # of the brushes' voltage: no drop is less or more, but for other causes


def _prior(subject: Subject, place: int) -> Prior | None:
    loss = subject.loss
    if loss is None or DROP not in loss.shapes:
        return None
    drop, deviation = loss.drop
    return Prior(deviation, mean=drop)


def _bounds(subject: Subject) -> tuple[float, float]:
    loss = subject.loss
    if loss is None:
        return 0.0, 0.0
    return LEAST * loss.brushes_v, MOST * loss.brushes_v + loss.drop[0]


BRUSH_DROP = InfluenceQuantity(
    name=DROP,
    unit="V",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(taken(DROP),),
    prior=_prior,
    scale=scales.top_volts,
    remedy="declare it (brush_drop_v of the rig), or add a level",
    bounds=_bounds,
)
