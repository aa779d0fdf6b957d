"""L that falls with the current: the iron saturates.

    dλ/di = L (1 - d i²/(i² + (i_stall/2)²))

Steps to several levels tell it, where the current is sampled several times within L/R.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Subject, Use
from motorid.estimate.effects.iron.share_of_inductance import ShareOfInductance, usual

USUAL = 0.2  # of L at a very large current: standard, stated by nobody
KNEE = 0.5  # of the stall current


def _knee(subject: Subject) -> float:
    return KNEE * scales.stall(subject)


SATURATION = InfluenceQuantity(
    name="saturation",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(ShareOfInductance("saturation", "saturation_current", _knee),),
    prior=usual(USUAL),
    scale=scales.one,
    remedy="sample the current faster, in steps to several levels",
    step=1e-4,
    term="saturation",
)
