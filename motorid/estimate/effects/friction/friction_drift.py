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
    Prior,
    Scope,
    Subject,
    Use,
)

USUAL = 0.03  # of T0, in a second or longer; in less time less: standard, stated by nobody
STRAIGHT = 1e-6  # of its rate over the capture: it goes by a straight line


@dataclass(frozen=True)
class FadingFriction(MotorParameter):
    """The torque that dry friction has more at the first tick than at the last."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        super().__call__(setup, subject, place, size)
        duration = _duration_s(subject)
        setup.motor["drift_span"], setup.motor["drift_rate"] = duration, STRAIGHT / duration


def _duration_s(subject: Subject) -> float:
    return float(subject.timeline.count * subject.timeline.period_s)


def _prior(subject: Subject, _: int) -> Prior | None:
    """Of a motor that has dry friction."""
    if subject.judged_at is None or not float(subject.judged_at[5]) > 0.0:
        return None
    return Prior(USUAL * min(_duration_s(subject), 1.0) * float(subject.judged_at[5]))


FRICTION_DRIFT = InfluenceQuantity(
    name="friction drift",
    unit="N·m",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(FadingFriction("drift"),),
    prior=_prior,
    scale=scales.friction,
    remedy="let the motor run before the capture, or drive the first level once more at its end",
    step=1e-4,
    term="friction-drift",
)
