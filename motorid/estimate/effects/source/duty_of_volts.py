"""The duty by which a board makes volts from a supply that it has read.

The mean voltage is measured, the duty is not: it decides the ripple.
"""

from __future__ import annotations

from dataclasses import replace

from motorid.capture.model import SUPPLY
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Bridge
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch
from motorid.program import Decay, StepKind


def _prior(subject: Subject, _: int) -> Prior | None:
    by_volts = any(
        p.kind == StepKind.DRIVE_VOLTS and p.decay != Decay.NONE for p in subject.timeline.parts
    )
    gain = subject.sensed.gain_uncertainty
    if not by_volts or not gain or subject.capture.get(SUPPLY) is not None:
        return None
    return Prior(gain)


def _at_duty(stretch: Stretch, part: Part, size: float) -> Stretch:
    """At 1 + size times its duty, the mean voltage being the same."""
    if part.kind != StepKind.DRIVE_VOLTS or not 0.0 < stretch.duty < 1.0:
        return stretch
    duty = 1.0 + size
    if part.decay == Decay.FAST:  # half of the period for no volts
        return replace(stretch, duty=0.5 + duty * (stretch.duty - 0.5))
    slow = part.decay == Decay.SYNCHRONOUS_SLOW
    swing = stretch.swing_v / duty if slow else stretch.swing_v
    return replace(stretch, duty=duty * stretch.duty, swing_v=swing)


DUTY_OF_VOLTS = InfluenceQuantity(
    name="duty of volts",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Bridge(_at_duty),),
    prior=_prior,
    scale=scales.one,
    remedy="capture the supply's voltage as well, or drive by duty",
)
