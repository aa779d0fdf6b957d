"""The torque that varies with the rotor's angle at any current: cogging, or a load out of balance.

The shaft's torque has T_c cos(N angle + phase) more.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import AlongAngle
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.effects.rotor.repeating import orders


def friction(subject: Subject) -> float:
    """N·m at the speed that the highest voltage would give."""
    return 1.0 if subject.judged_at is None else scales.friction(subject)


COGGING = InfluenceQuantity(
    name="cogging torque",
    unit="N·m",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(AlongAngle(),),
    prior=lambda subject, place: Prior(friction(subject)),
    scale=friction,
    remedy="record more turns at each level",
    places=orders,
    listed=False,
)
