"""K that falls with the current: the armature's field weakens that of the magnets.

    K(i) = K (1 - a |i|)

A run whose current changes at speed tells it. Where none does, torque and back-EMF show K at
different currents.
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

USUAL = 0.02  # of K at the stall current of the highest voltage: standard, stated by nobody


def _scale(subject: Subject) -> float:
    return 1.0 / scales.stall(subject)


def _prior(subject: Subject, _: int) -> Prior | None:
    return None if subject.judged_at is None else Prior(USUAL * _scale(subject))


ARMATURE_REACTION = InfluenceQuantity(
    name="armature reaction",
    unit="1/A",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(MotorParameter("reaction"),),
    prior=_prior,
    scale=_scale,
    remedy="record a run that reverses, or brakes, at speed",
    step=1e-4,
    term="armature-reaction",
)
