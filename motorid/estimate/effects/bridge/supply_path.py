"""The resistance between the point where the supply is read and the bridge: a fuse, or a wire.

    lost(t) = r d² i

A switch against reversed polarity has one as well. The bridge draws |d| i of the supply, which
takes r |d| i from its voltage, and the motor gets d of it. A bridge's own resistance takes r i at
any duty. So levels of unlike duty tell the two apart.
"""

from __future__ import annotations

from dataclasses import replace

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Bridge
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Use,
    undeclared,
)
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch
from motorid.program import Decay, StepKind


def _duty(stretch: Stretch, part: Part) -> float:
    """Share of the supply that drives the motor; none where diodes carry the rest of a period."""
    match part.kind, part.decay:
        case StepKind.DRIVE_DUTY, Decay.SYNCHRONOUS_SLOW | Decay.FAST:
            return part.level
        case StepKind.DRIVE_VOLTS, Decay.SYNCHRONOUS_SLOW:
            return stretch.duty
        case StepKind.DRIVE_VOLTS, Decay.FAST:
            return 2.0 * stretch.duty - 1.0
    return 0.0


def _behind(stretch: Stretch, part: Part, size: float) -> Stretch:
    """Behind so many ohms more of the supply."""
    return replace(stretch, series_ohm=stretch.series_ohm + size * _duty(stretch, part) ** 2)


SUPPLY_PATH = InfluenceQuantity(
    name="supply path",
    unit="ohm",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(Bridge(_behind),),
    prior=undeclared,
    scale=scales.one,
    remedy="read the supply at the bridge itself",
)
