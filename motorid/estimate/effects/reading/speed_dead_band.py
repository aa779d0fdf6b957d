"""The speed that a tachogenerator swallows: brushes or a rectifier keep a fixed voltage of it.

    shown = sign(ω) max(|ω| − d, 0)

It shows too little at every speed, so that K of the back-EMF seems to be larger at low ones.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Floats, Reading
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)

SMALL = 1e-4  # of the readings' extent: hardly any reading lies within


def _scale(subject: Subject) -> float:
    return SMALL * scales.extent(SPEED)(subject)


def swallowed(series: Floats, size: Floats | float) -> Floats:
    """(n,) nearer to zero by ``size``, and zero within it."""
    return np.asarray(np.sign(series) * np.maximum(np.abs(series) - size, 0.0))


SPEED_DEAD_BAND = InfluenceQuantity(
    name="speed dead band",
    unit="rad/s",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(Reading(SPEED, swallowed),),
    prior=undeclared,
    scale=_scale,
    remedy="load the tachogenerator less, rectify it without diodes, or take an encoder",
)
