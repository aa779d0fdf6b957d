"""The delay, beyond the declared one, of the terminals' voltage while the bridge is open."""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Delay
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Subject, Use
from motorid.estimate.signals.measurements import EMF


def _bounds(subject: Subject) -> tuple[float, float]:
    return scales.least_delay_s(subject.block(EMF)), np.inf


VOLTAGE_DELAY = InfluenceQuantity(
    name="voltage delay",
    unit="s",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Delay(EMF),),
    prior=scales.declared(EMF, "delay_uncertainty_s"),
    scale=scales.period_s,
    remedy="measure the delay of the voltage's channel",
    bounds=_bounds,
    step=2e-4,
)
