"""The voltage channel's zero: the source has less than it reads, an open bridge reads more."""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, SourceVoltage, plus
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.measurements import EMF

QUIET = 10  # readings of an open bridge that tell it


def _prior(subject: Subject, _: int) -> Prior | None:
    sensed, emf = subject.sensed, subject.block(EMF)
    if sensed.channel is None or not sensed.shows_emf:
        return None
    sd = sensed.channel.offset_uncertainty or np.inf
    told = emf is not None and len(emf.values) >= QUIET
    return Prior(sd) if np.isfinite(sd) or told else None


VOLTAGE_OFFSET = InfluenceQuantity(
    name="voltage offset",
    unit="V",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(SourceVoltage(lambda subject, place: -1.0), Reading(EMF, plus)),
    prior=_prior,
    scale=scales.volts,
    remedy="record the terminals' voltage with the bridge open and the rotor at rest",
)
