"""The gain of an encoder (counts a turn, gear ratio) or of a speed's channel."""

from __future__ import annotations

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, times
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _prior(subject: Subject, _: int) -> Prior | None:
    measured = scales.moving(subject)
    sd = measured.channel.gain_uncertainty if measured is not None else 0.0
    return Prior(sd) if sd else None


MOTION_GAIN = InfluenceQuantity(
    name="encoder or speed gain",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Reading(POSITION, times), Reading(SPEED, times)),
    prior=_prior,
    scale=scales.one,
    remedy="calibrate the encoder's counts or the speed's gain",
)
