"""The drop of two diodes, in the off part of diode decay and while a coast's current decays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorid.estimate.effects.action import Bridge
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.source.pwm_bridge import DIODE_DROPS_SD_V
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch
from motorid.program import Decay


def _prior(subject: Subject, _: int) -> Prior | None:
    decays = any(part.decay == Decay.DIODE for part in subject.timeline.parts)
    return Prior(DIODE_DROPS_SD_V) if decays else None


def _more(stretch: Stretch, part: Part, size: float) -> Stretch:
    swings = part.decay == Decay.DIODE and stretch.swing_v
    swing = size * float(np.sign(stretch.swing_v)) if swings else 0.0
    clamp = stretch.clamp_v + size if stretch.clamp_v else 0.0
    return replace(stretch, swing_v=stretch.swing_v + swing, clamp_v=clamp)


DIODE_DROPS = InfluenceQuantity(
    name="diode drops",
    unit="V",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Bridge(_more),),
    prior=_prior,
    scale=lambda subject: 1.0,
    remedy="drive with synchronous decay",
    step=1e-3,
)
