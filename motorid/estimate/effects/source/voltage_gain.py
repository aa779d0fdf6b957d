"""The gain of the channel that shows the voltage, or of the supply by which it is commanded."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, SourceGain, times
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.measurements import EMF


def _prior(subject: Subject, _: int) -> Prior | None:
    sd = subject.sensed.gain_uncertainty
    return Prior(sd) if sd else None


VOLTAGE_GAIN = InfluenceQuantity(
    name="voltage gain",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(SourceGain(-1.0), Reading(EMF, times)),  # what reads too much had less behind it
    prior=_prior,
    scale=scales.one,
    remedy="calibrate the voltage's gain (motorid calibrate)",
)
