"""What the current's channel reads at no current while the bridge switches, and only then.

A ground that the motor's own current lifts, or pulses that reach into the sensor's leads.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, plus
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Use,
    undeclared,
)


def _while_driven(subject: Any) -> NDArray[np.float64]:
    measured = subject.block(CURRENT)
    return np.asarray(subject.driven[measured.keep], dtype=np.float64)


DRIVEN_CURRENT_OFFSET = InfluenceQuantity(
    name="current offset while driven",
    unit="A",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(Reading(CURRENT, plus, _while_driven),),
    prior=undeclared,
    scale=scales.extent(CURRENT),
    remedy="take the sensor's zero with the bridge switching, and keep its leads away from it",
)
