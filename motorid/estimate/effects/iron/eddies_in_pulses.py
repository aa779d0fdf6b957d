"""Eddy currents in iron, where only what happens within PWM periods tells L.

A pulse of current holds frequencies above that of the PWM, and the higher they are, the less of L
is left by eddy currents. How much depends on the iron, and nobody says that there are none. Slower
readings tell them (eddy_currents.py).
"""

from __future__ import annotations

from typing import Any

from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Prior, Scope, Use

USUAL = 0.15  # of L, of what they may do to it within PWM periods: standard, stated by nobody
WITHIN = 0.2  # of a sample period: L/R of which only what happens within it is seen


def told_within(subject: Any) -> bool:
    """Readings of pulses tell L, and no slower ones."""
    motor, period = subject.judged_at, subject.timeline.period_s
    pulsed = any(part.discontinuous for part in subject.shown_parts)
    if motor is None or subject.foretold is not None or not pulsed:
        return False
    return bool(0.0 < motor[1] < WITHIN * period * motor[0])


def _inductance(subject: Any) -> float:
    return float(subject.judged_at[1])


def _prior(subject: Any, _: int) -> Prior | None:
    return Prior(sd=USUAL * _inductance(subject)) if told_within(subject) else None


EDDIES_IN_PULSES = InfluenceQuantity(
    name="eddy currents in pulses",
    unit="H",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(MotorParameter("L"),),
    prior=_prior,
    scale=_inductance,
    step=1e-3,
    remedy="sample the current several times within L/R, or measure L apart (--fix L)",
)
