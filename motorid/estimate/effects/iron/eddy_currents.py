"""A part of L beside a resistance: the iron, in which eddy currents flow.

    L1 di/dt + u, u = L2 die/dt = Rc (i - ie), L2 = share L, L2/Rc = TIME_S

What changes slowly meets the whole of L, what changes fast L1 alone. Steps tell it, where the
current is sampled several times within L/R.
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

USUAL = 0.2  # of L: standard, stated by nobody
TIME_S = 1e-4  # of L2 beside the resistance: the middle of what motors have, 30 to 300 us


class _Shields(Simulated):
    """A share of L lies beside a resistance."""

    def __call__(self, setup: Setup, subject: Any, place: int, size: float) -> None:
        setup.motor["eddy"] = setup.motor.get("eddy", 0.0) + size
        setup.motor["eddy_time"] = TIME_S


def _prior(subject: Subject, _: int) -> Prior | None:
    if subject.judged_at is None or not float(subject.judged_at[1]) > 0.0:
        return None
    return Prior(USUAL)


EDDY_CURRENTS = InfluenceQuantity(
    name="eddy currents",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(_Shields(),),
    prior=_prior,
    scale=scales.one,
    remedy="sample the current faster, or measure L apart (--fix L)",
    step=1e-4,
    term="eddy",
)
