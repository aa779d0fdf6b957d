"""The angle at which the encoder reads zero."""

from __future__ import annotations

from motorid.capture.model import POSITION
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, plus
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _prior(subject: Subject, _: int) -> Prior | None:
    measured = subject.block(POSITION)
    return None if measured is None else Prior(start=float(measured.values[0]))


POSITION_ORIGIN = InfluenceQuantity(
    name="position origin",
    unit="rad",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(Reading(POSITION, plus),),
    prior=_prior,
    scale=scales.extent(POSITION),
    remedy="nothing: each run has an origin of its own",
)
