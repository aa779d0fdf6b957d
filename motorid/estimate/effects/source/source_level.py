"""The error of a part's voltage level, which is the mean of noisy readings."""

from __future__ import annotations

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


def _levels(subject: Subject) -> Sequence[int]:
    return subject.noise.levels


def _prior(subject: Subject, place: int) -> Prior | None:
    return Prior(subject.noise.level_deviation(place, subject.sources[place]))


SOURCE_LEVEL = InfluenceQuantity(
    name="source level",
    unit="V",
    scope=Scope.PART,
    use=Use.ESTIMATED,
    acts=(PartVoltage(),),
    prior=_prior,
    scale=scales.volts,
    remedy="hold each level longer",
    places=_levels,
    listed=False,
)
