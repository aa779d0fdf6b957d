"""The speed with which a run begins that does not begin at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.standstill import HEAD, starts_at_rest

Floats = NDArray[np.float64]


def _first(subject: Subject) -> Floats | None:
    """Speeds (n,) by the first readings; None: no motion was measured."""
    measured = scales.moving(subject)
    if measured is None:
        return None
    if measured.block.name == SPEED:
        return np.asarray(measured.values[:HEAD])
    assert measured.block.name == POSITION
    ticks = measured.keep[:HEAD] * subject.timeline.period_s
    return np.asarray(np.gradient(measured.values[:HEAD], ticks))


def _prior(subject: Subject, _: int) -> Prior | None:
    first = _first(subject)
    if first is None or starts_at_rest(subject.capture, subject.driven):
        return None
    return Prior(start=float(first.mean()))


def _scale(subject: Subject) -> float:
    first = _first(subject)
    return 1.0 if first is None else scales.extent_of(first)


INITIAL_SPEED = InfluenceQuantity(
    name="initial speed",
    unit="rad/s",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(InitialState(1),),
    prior=_prior,
    scale=_scale,
    remedy="begin the run at rest",
)
