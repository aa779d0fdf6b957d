"""The pulse-width distortion of a bridge: its pulses are longer than commanded, by a fixed time.

    more(t) = x f V sign(duty),    0 < |duty| < 1

x is by how much the delay before a pulse is shorter than that after it, f the PWM frequency, V the
supply. At full duty there are no edges. So levels below the highest err together, which looks like
friction or a drop of the brushes. Where both half bridges switch (fast decay) it cancels.

Of a gate driver x is some 10 ns, and of integrated bridges up to 1 µs: the BTS7960's data sheet
states delays of 3.1 and 2.4 µs. Where the voltage is measured its readings have it.
"""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Floats, SourceVoltage
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.source.pwm_bridge import signed_duty
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay

USUAL_S = 1e-7  # standard, where nothing is declared


def _switched(part: Part, supply_v: float | None) -> bool:
    """One half bridge alone switches."""
    duty = abs(signed_duty(part, supply_v))
    return part.decay == Decay.SYNCHRONOUS_SLOW and 0.0 < duty < 1.0


def _volts(subject: Subject, _: int) -> Floats:
    """V/s (count,) that a longer pulse adds."""
    volts, supply_v = np.zeros(subject.timeline.count), subject.capture.supply_v
    for part in subject.timeline.parts:
        if _switched(part, supply_v):
            volts[part.slice] = np.copysign(supply_v or 0.0, part.level) / subject.pwm_period_s
    return volts


def _prior(subject: Subject, _: int) -> Prior | None:
    if not subject.sensed.commanded or not subject.pwm_period_s:
        return None
    supply_v = subject.capture.supply_v
    switched = any(_switched(part, supply_v) for part in subject.timeline.parts)
    return Prior(USUAL_S) if switched else None


PULSE_DISTORTION = InfluenceQuantity(
    name="pulse-width distortion",
    unit="s",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(SourceVoltage(_volts),),
    prior=_prior,
    scale=scales.period_s,
    remedy="measure the voltage at the motor's terminals, or add a level at full duty",
)
