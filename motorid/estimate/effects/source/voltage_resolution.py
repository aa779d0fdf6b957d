"""The converter's step of the voltage, where no noise dithers it away."""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects.action import SourceVoltage
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

DITHER = 0.3  # of a step: so much noise makes the mean of readings finer than it


def _prior(subject: Subject, _: int) -> Prior | None:
    resolution = subject.sensed.resolution
    noise = max((s.noise for s in subject.sources if s is not None), default=np.inf)
    if not resolution or noise > DITHER * resolution:
        return None
    return Prior(resolution / np.sqrt(12.0))


VOLTAGE_RESOLUTION = InfluenceQuantity(
    name="voltage resolution",
    unit="V",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(SourceVoltage(lambda subject, place: np.sign(subject.volts)),),
    prior=_prior,
    scale=lambda subject: 1.0,
    remedy="measure the voltage with a finer converter or a smaller range",
    step=1e-3,
)
