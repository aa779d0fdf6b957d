"""A share of L that is not there at some current or frequency: what its declarations have alike."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from motorid.estimate.effects.action import MotorParameter, Setup
from motorid.estimate.effects.influence_quantity import Prior, Subject


@dataclass(frozen=True)
class ShareOfInductance(MotorParameter):
    """A term of the motor by its size, and where it sets in by another parameter (SI)."""

    where: str
    at: Callable[[Any], float]

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        super().__call__(setup, subject, place, size)
        setup.motor[self.where] = self.at(subject)


def usual(share: float) -> Callable[[Subject, int], Prior | None]:
    """The prior of a share: of motors that have an inductance."""

    def prior(subject: Subject, _: int) -> Prior | None:
        if subject.judged_at is None or not float(subject.judged_at[1]) > 0.0:
            return None
        return Prior(share)

    return prior
