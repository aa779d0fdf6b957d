"""The voltage that a bridge's bipolar switches drop, where the voltage is read before the bridge.

    lost(t) = V s,    s = i / sqrt(i² + b²)

It bends as the brushes' does, with the same b: an L298's two switches keep 2 to 3 V at large
currents, and less at small ones. So no reading tells the two apart: each has the prior that the rig
declares.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.brush_and_heating import BRIDGE, taken
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

MOST = 3.0  # of what is declared: no bridge of that kind drops more


def _prior(subject: Subject, place: int) -> Prior | None:
    loss = subject.loss
    if loss is None or BRIDGE not in loss.shapes:
        return None
    drop, deviation = loss.bridge
    return Prior(deviation, mean=drop)


def _bounds(subject: Subject) -> tuple[float, float]:
    loss = subject.loss
    return (0.0, 0.0) if loss is None else (0.0, MOST * loss.bridge[0])


BRIDGE_DROP = InfluenceQuantity(
    name=BRIDGE,
    unit="V",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(taken(BRIDGE),),
    prior=_prior,
    scale=scales.top_volts,
    remedy="measure the voltage at the motor's terminals, or take a bridge of MOSFETs",
    bounds=_bounds,
)
