"""The torque that varies with the rotor's angle at any current: cogging, or a load out of balance.

The shaft's torque has T_c cos(N angle + phase) more.
"""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects.action import AlongAngle
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.effects.rotor.repeating import orders

LEAST = 1e-3  # of the stall torque: friction that counts


def friction(subject: Subject) -> float:
    """N·m at the speed that the highest voltage would give."""
    if subject.judged_at is None:
        return 1.0
    R, _, K, B, _, T0 = (float(x) for x in subject.judged_at[:6])
    volts = float(np.abs(subject.volts).max()) or 1.0
    return max(T0 + B * volts / K, LEAST * K * volts / R)


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
