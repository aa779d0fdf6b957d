"""The speed at which a coast begins, above that by the mean voltage.

A bridge that renews its duty by a noisy measurement really jitters: a motor enters its coast a
little faster or slower, and stays so.
"""

from __future__ import annotations

from collections.abc import Sequence

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Kick
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _coasts(subject: Subject) -> Sequence[int]:
    return subject.noise.coasts if scales.speed(subject) else ()


def _prior(subject: Subject, place: int) -> Prior | None:
    if subject.judged_at is None:
        return Prior()
    source = subject.sources[place - 1]
    return Prior(subject.noise.speed_deviation(place, source, subject.judged_at))


COAST_START = InfluenceQuantity(
    name="coast start",
    unit="rad/s",
    scope=Scope.PART,
    use=Use.ESTIMATED,
    acts=(Kick(),),
    prior=_prior,
    scale=scales.speed,
    remedy="drive by a quieter supply, or take more runs",
    places=_coasts,
    listed=False,
)
