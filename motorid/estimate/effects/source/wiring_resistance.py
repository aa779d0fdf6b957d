"""Leads and bridge between the sense point and the motor, whose resistance is taken off R."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _prior(subject: Subject, _: int) -> Prior | None:
    sd = subject.sensed.series_uncertainty_ohm
    return Prior(sd) if sd else None


WIRING_RESISTANCE = InfluenceQuantity(
    name="wiring resistance",
    unit="ohm",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(MotorParameter("R"),),
    prior=_prior,
    scale=scales.one,
    remedy="measure the leads' and the bridge's resistance",
)
