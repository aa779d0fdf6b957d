"""The encoder's error once in its turn, of a disc off its centre, where its amplitude is declared.

    shown = angle + a cos(angle) + b sin(angle)

Nobody knows at which angle a run begins, so each capture has both sizes. One amplitude e, at any
phase, makes either of them 0 within e/sqrt(2), standard.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import POSITION
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Added, Floats
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

WAVES = (np.cos, np.sin)


def _course(subject: Subject, place: int, _: Floats) -> Floats:
    """rad of the motor's shaft (n,), by the angle that the encoder itself shows."""
    measured, gear = subject.block(POSITION), subject.capture.wiring.gear_ratio or 1.0
    assert measured is not None
    return np.asarray(gear * WAVES[place](measured.values / gear))


def _prior(subject: Subject, _: int) -> Prior | None:
    amplitude = subject.capture.wiring.encoder_eccentricity_rad
    if not amplitude or subject.block(POSITION) is None:
        return None
    return Prior(amplitude / 2.0**0.5)


ENCODER_ECCENTRICITY = InfluenceQuantity(
    name="encoder eccentricity",
    unit="rad",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(Added(POSITION, _course),),
    prior=_prior,
    scale=lambda subject: subject.capture.wiring.encoder_eccentricity_rad or scales.one(subject),
    remedy="centre the encoder's disc, or record more turns at each level",
    places=lambda subject: range(len(WAVES)),
)
