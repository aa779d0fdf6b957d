"""The current with which a run begins that does not begin at rest."""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.standstill import starts_at_rest

MOST = 10.0  # times the largest current of a run: more than any winding gave the ones it shows


def _bounds(subject: Subject) -> tuple[float, float]:
    """Of either sign. Where the first reading comes when the current has died away, nothing but the
    speed shows it, and the two would run away together: an absurd current stops an absurd speed.
    """
    measured = subject.block(CURRENT)
    most = 0.0 if measured is None else MOST * float(np.abs(measured.values).max(initial=0.0))
    return (-most, most) if most else (-np.inf, np.inf)


def _prior(subject: Subject, _: int) -> Prior | None:
    measured = subject.block(CURRENT)
    if measured is None or not subject.driven[0]:
        return None
    if starts_at_rest(subject.capture, subject.driven):
        return None
    return Prior(start=float(measured.values[0]))


INITIAL_CURRENT = InfluenceQuantity(
    name="initial current",
    unit="A",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(InitialState(0),),
    prior=_prior,
    scale=scales.extent(CURRENT),
    remedy="begin the run at rest",
    bounds=_bounds,
)
