"""The clock of the board: what it counts as a second, and all that it times by it."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import TimeBase
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _prior(subject: Subject, _: int) -> Prior | None:
    sd = subject.capture.clock_uncertainty
    return Prior(sd) if sd else None


CLOCK = InfluenceQuantity(
    name="clock",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(TimeBase(),),
    prior=_prior,
    scale=scales.one,
    remedy="calibrate the board's clock (motorid calibrate)",
)
