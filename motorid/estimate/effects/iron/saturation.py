"""L that falls with the current: the iron saturates.

    dλ/di = L (1 - d i²/(i² + (i_stall/2)²))

Steps to several levels tell it, where the current is sampled several times within L/R.
"""

from __future__ import annotations

from typing import Any

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Setup, Simulated
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

USUAL = 0.2  # of L at a very large current: standard, stated by nobody
KNEE = 0.5  # of the stall current


class _Saturates(Simulated):
    """A share of L goes, half of it at a part of the stall current."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.motor["saturation"] = setup.motor.get("saturation", 0.0) + size
        setup.motor["saturation_current"] = KNEE * scales.stall(subject)


def _prior(subject: Subject, _: int) -> Prior | None:
    if subject.judged_at is None or not float(subject.judged_at[1]) > 0.0:
        return None
    return Prior(USUAL)


SATURATION = InfluenceQuantity(
    name="saturation",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(_Saturates(),),
    prior=_prior,
    scale=scales.one,
    remedy="sample the current faster, in steps to several levels",
    step=1e-4,
    term="saturation",
)
