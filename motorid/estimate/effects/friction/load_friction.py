"""Friction that grows with the torque of the current: bearings and gears under load.

    friction = T0 + B w + c |K i|

Driving forwards and coasting, it makes J, B and T0 larger by c, and leaves no residual. A run that
brakes, or reverses against the motion, tells it: there it helps the torque.
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

USUAL = 0.025  # of the torque: standard, stated by nobody


def _prior(subject: Subject, _: int) -> Prior | None:
    return None if subject.judged_at is None else Prior(USUAL)


LOAD_FRICTION = InfluenceQuantity(
    name="load friction",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(MotorParameter("load_friction"),),
    prior=_prior,
    scale=scales.one,
    remedy="record a run that brakes, or reverses against the motion",
    step=1e-4,
    term="load-friction",
)
