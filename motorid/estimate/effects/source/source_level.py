"""The error of a part's voltage level: the mean of noisy readings of a converter that bends."""

from __future__ import annotations

import math
from collections.abc import Sequence

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import PartVoltage
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

BENT = 10.0  # steps of a converter: none is farther off its straight line


def _levels(subject: Subject) -> Sequence[int]:
    return subject.noise.levels


def _prior(subject: Subject, place: int) -> Prior | None:
    return Prior(subject.noise.level_deviation(place, subject.sources[place]))


def _bounds(subject: Subject) -> tuple[float, float]:
    """V: what is farther off than any converter is a fault, and shows as one."""
    most = BENT * subject.sensed.resolution or math.inf
    return -most, most


SOURCE_LEVEL = InfluenceQuantity(
    name="source level",
    unit="V",
    scope=Scope.PART,
    use=Use.ESTIMATED,
    acts=(PartVoltage(),),
    prior=_prior,
    scale=scales.volts,
    bounds=_bounds,
    remedy="hold each level longer",
    places=_levels,
    listed=False,
)
