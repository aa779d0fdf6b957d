"""The current with which a run begins that does not begin at rest."""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.standstill import starts_at_rest


def _prior(subject: Subject, _: int) -> Prior | None:
    measured = subject.block(CURRENT)
    if measured is None or not subject.driven[0]:
        return None
    if starts_at_rest(subject.capture, subject.driven):
        return None
    return Prior(start=float(measured.values[0]))


INITIAL_CURRENT = InfluenceQuantity(
    name="initial current",
    unit="A",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(InitialState(0),),
    prior=_prior,
    scale=scales.extent(CURRENT),
    remedy="begin the run at rest",
)
