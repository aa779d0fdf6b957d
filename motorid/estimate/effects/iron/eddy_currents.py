"""A part of L beside a resistance: the iron, in which eddy currents flow.

    L1 di/dt + u, u = L2 die/dt = Rc (i - ie), L2 = share L, L2/Rc = TIME_S

What changes slowly meets the whole of L, what changes fast L1 alone. Steps tell it, where the
current is sampled several times within L/R.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use
from motorid.estimate.effects.iron.share_of_inductance import ShareOfInductance, usual

USUAL = 0.2  # of L: standard, stated by nobody
TIME_S = 1e-4  # of L2 beside the resistance: the middle of what motors have, 30 to 300 us

EDDY_CURRENTS = InfluenceQuantity(
    name="eddy currents",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(ShareOfInductance("eddy", "eddy_time", lambda _: TIME_S),),
    prior=usual(USUAL),
    scale=scales.one,
    remedy="sample the current faster, or measure L apart (--fix L)",
    step=1e-4,
    term="eddy",
)
