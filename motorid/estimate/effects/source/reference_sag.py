"""The fall of the converters' reference with the motor's current, by which all gains rise alike.

    shown = true (1 + size |i|)

A board that feeds its converters from a rail which the motor loads reads current and voltage too
high as long as current flows. What drove the motor is what was read, less that of the current that
was read with it: to first order of the size. A sensor that follows the reference shows its current
as before. K w + R i rises in the readings with the current, and K i too: K of the back-EMF seems to
rise with the current and K of the torque to fall, as no motor's does. So the readings determine it.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Added, Floats, SourceVoltage
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)


def _lost_volts(subject: Subject, _: int) -> Floats:
    """V/(1/A) (count,): what reads too much had less behind it."""
    measured = subject.block(CURRENT)
    if measured is None:
        return np.zeros(subject.timeline.count)
    ticks = np.arange(subject.timeline.count)
    return -np.interp(ticks, measured.keep, np.abs(measured.values)) * subject.volts


def _of_current(subject: Subject, _: int, amperes: Floats) -> Floats:
    """A/(1/A) (n,), beside a current (n,) in A."""
    measured = subject.block(CURRENT)
    if measured is None or measured.channel.ratiometric:
        return np.zeros(len(amperes))
    return amperes * np.abs(amperes)


def _scale(subject: Subject) -> float:
    return 1.0 / scales.extent(CURRENT)(subject)


REFERENCE_SAG = InfluenceQuantity(
    name="sag of the reference",
    unit="1/A",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(SourceVoltage(_lost_volts), Added(CURRENT, _of_current)),
    prior=undeclared,
    scale=_scale,
    remedy="feed the converters' reference from a source of its own that the motor does not load",
)
