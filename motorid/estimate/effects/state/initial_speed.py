"""The speed with which a run begins that does not begin at rest.

A log may begin, or go on after a pause, while the motor turns. Without a motion channel only its
back-EMF shows that, in what R i leaves of the first voltage. Taken for a start at rest, the
back-EMF would pass for a voltage across R. A log that begins with a current that rises from none is
taken to begin at rest: it was triggered by the step.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import InitialState
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.standstill import HEAD, starts_at_rest, switched_on, unpowered

Floats = NDArray[np.float64]

ROTOR = {"B", "J", "T0"}  # all held: nobody looks for a motion
USUAL = 0.65  # of the largest R that a peak of the current allows: the middle of what is tried


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


def _unread(subject: Subject) -> Prior | None:
    """Of a log without a motion: the start by its first back-EMF; None: it begins at rest."""
    current, held = subject.block(CURRENT), subject.held
    if subject.capture.program is not None or current is None or not subject.driven[0]:
        return None
    if held.keys() >= ROTOR or unpowered(subject.capture) or switched_on(subject.capture):
        return None
    volts, amperes = subject.sensed.volts, current.values
    most = float(np.abs(volts).max()) / (float(np.abs(amperes).max()) or 1.0)
    emf = float(volts[:HEAD].mean()) - USUAL * most * float(amperes[:HEAD].mean())
    return Prior(start=emf / held.get("K", 1.0))


def _prior(subject: Subject, _: int) -> Prior | None:
    first = _first(subject)
    if first is None:
        return _unread(subject)
    if starts_at_rest(subject.capture, subject.driven):
        return None
    return Prior(start=float(first.mean()))


def _scale(subject: Subject) -> float:
    first = _first(subject)
    return scales.volts(subject) if first is None else scales.extent_of(first)


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
