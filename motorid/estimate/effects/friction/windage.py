"""Friction that grows with the square of the speed, of which no reading was found to speak.

    friction = T0 + B w + T_lc w |w|

Between two speeds a little windage looks like more B and less T0. Three speeds or a coast tell it.
Nobody chose those of a log, and without a motion no speed is read: there what is usual of it is a
line of the budget even where the readings hardly tell it. Where B is held at nothing, as without a
current, where nobody tells it from K, dry friction takes its place.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

USUAL = 0.25  # of the viscous torque at no load: standard, stated by nobody


def _scale(subject: Subject) -> float:
    """The viscous torque at the speed of the highest voltage, over that speed's square."""
    if subject.judged_at is None:
        return 1.0
    return (
        scales.friction(subject, dry=subject.held.get("B") == 0.0) / scales.top_speed(subject) ** 2
    )


def _prior(subject: Subject, _: int) -> Prior | None:
    return None if subject.judged_at is None else Prior(USUAL * _scale(subject))


def _is_kept(subject: Subject) -> bool:
    """In a log, and without a motion."""
    return scales.moving(subject) is None or subject.sensed.waveform is not None


WINDAGE = InfluenceQuantity(
    name="quadratic load",
    unit="N·m·s²/rad²",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(MotorParameter("quadratic"),),
    prior=_prior,
    scale=_scale,
    kept=_is_kept,
    remedy="record three levels of speed or more, and a coast from the highest",
    term="quadratic-load",
)
