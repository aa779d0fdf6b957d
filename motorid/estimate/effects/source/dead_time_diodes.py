"""The drop of two diodes during dead time, where the voltage is commanded and not measured."""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.brush_and_heating import DIODES, taken
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_SD_V


def _prior(subject: Subject, place: int) -> Prior | None:
    loss = subject.loss
    if loss is None or DIODES not in loss.shapes:
        return None
    return Prior(DIODE_DROPS_SD_V)


DEAD_TIME_DIODES = InfluenceQuantity(
    name=DIODES,
    unit="V",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(taken(DIODES),),
    prior=_prior,
    scale=scales.top_volts,
    remedy="measure the voltage at the motor's terminals",
    listed=False,
)
