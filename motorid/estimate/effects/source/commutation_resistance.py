"""R that rises with speed: brushes short the coils that they commutate, and lift.

    R(w) = R + c |w|

A coil gives off the energy ½ Lc i² of its field at each commutation, and commutations come in
proportion to the speed. All of it in the brushes makes c (2/π) L at most, for a winding of two
poles whose coils do not couple. R is that at no speed. A current that flows at speed, and the same
one at rest, tell it.
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

USUAL = 0.01  # of R at the speed of the highest voltage: standard, stated by nobody


def _scale(subject: Subject) -> float:
    """R over that speed."""
    assert subject.judged_at is not None
    return float(subject.judged_at[0]) / scales.top_speed(subject)


def _prior(subject: Subject, _: int) -> Prior | None:
    return None if subject.judged_at is None else Prior(USUAL * _scale(subject))


COMMUTATION_RESISTANCE = InfluenceQuantity(
    name="commutation resistance",
    unit="ohm·s/rad",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(MotorParameter("commutation"),),
    prior=_prior,
    scale=_scale,
    remedy="record a run that reverses, or brakes, at speed",
    step=1e-4,
    term="commutation-resistance",
)
