"""Share of the dead time that is lost where the current changes its sign within the PWM period.

Of a part of the program whose voltage is commanded and not measured.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorid.estimate.effects.action import PartLoss
from motorid.estimate.effects.brush_and_heating import TURN, turn_of
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.source.dead_time import UNSURE

FARTHEST = 0.5  # relative


def _prior(subject: Subject, place: int) -> Prior | None:
    loss = subject.loss
    if loss is None or place not in loss.turns:
        return None
    return Prior(UNSURE)


def _bounds(subject: Subject) -> tuple[float, float]:
    return -FARTHEST, FARTHEST


def _turns(subject: Subject) -> Sequence[int]:
    return tuple(subject.loss.turns) if subject.loss is not None else ()


DEAD_TIME_TURN = InfluenceQuantity(
    name=TURN,
    unit="1",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(PartLoss(lambda subject, place: subject.loss.shapes[turn_of(place)]),),
    prior=_prior,
    scale=lambda subject: UNSURE,
    remedy="measure the voltage at the motor's terminals",
    bounds=_bounds,
    places=_turns,
    listed=False,
)
