"""The delay of the encoder or speed readings beyond the declared one."""

from __future__ import annotations

import numpy as np

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Delay
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _prior(subject: Subject, _: int) -> Prior | None:
    measured = scales.moving(subject)
    sd = measured.channel.delay_uncertainty_s if measured is not None else 0.0
    return Prior(sd) if sd else None


def _bounds(subject: Subject) -> tuple[float, float]:
    return scales.least_delay_s(scales.moving(subject)), np.inf


MOTION_DELAY = InfluenceQuantity(
    name="encoder or speed delay",
    unit="s",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Delay(POSITION), Delay(SPEED)),
    prior=_prior,
    scale=scales.period_s,
    remedy="measure the delay of the encoder's or the speed's channel",
    bounds=_bounds,
    step=2e-4,
)
