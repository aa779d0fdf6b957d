"""Dry friction that changes while the motor runs: bearings warm up, grease is spread, brushes seat.

    friction = T0 + drift (1 - t / duration), t the time since the first tick

Runs that come late then show less friction than those before. The same level of voltage at the
beginning and at the end tells it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import MotorParameter, Setup
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)

STRAIGHT = 1e-6  # of its rate over the capture: it goes by a straight line


@dataclass(frozen=True)
class FadingFriction(MotorParameter):
    """The torque that dry friction has more at the first tick than at the last."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        super().__call__(setup, subject, place, size)
        duration = subject.timeline.count * subject.timeline.period_s
        setup.motor["drift_span"], setup.motor["drift_rate"] = duration, STRAIGHT / duration


def _scale(subject: Subject) -> float:
    """N·m: the friction at the speed that the highest voltage would give."""
    return 1.0 if subject.judged_at is None else scales.friction(subject)


FRICTION_DRIFT = InfluenceQuantity(
    name="friction drift",
    unit="N·m",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(FadingFriction("drift"),),
    prior=undeclared,
    scale=_scale,
    remedy="let the motor run before the capture, or fit it: --model friction-drift",
)
