"""An inductance that no reading shows, as known from the PWM ripple of the current.

It is held in the fit; what is unknown of it is a line of the budget.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import MotorParameter
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use, undeclared


@dataclass(frozen=True)
class Foretold:
    """The inductance (H), by what it is known, and by how much each parameter's search coordinate
    moves if it is larger by one standard uncertainty.
    """

    inductance_h: float
    by: str
    shift: Mapping[str, float]


HELD_INDUCTANCE = InfluenceQuantity(
    name="PWM ripple",
    unit="H",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(MotorParameter("L"),),
    prior=undeclared,
    scale=scales.one,
    remedy="sample the current several times within L/R, or measure L apart (--fix L)",
)
