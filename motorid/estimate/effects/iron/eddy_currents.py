"""A part of L beside a resistance: the iron, in which eddy currents flow.

    L1 di/dt + u, u = L2 die/dt = Rc (i - ie), L2 = share L, L2/Rc = t_e

What changes slowly meets the whole of L, what changes fast L1 alone. Steps tell it, where the
current is sampled several times within L/R.
"""

from __future__ import annotations

import math

from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Shape, Use
from motorid.estimate.effects.iron.share_of_inductance import ShareOfInductance, usual

USUAL = 0.2  # of L: standard, stated by nobody
SHORTEST_S, LONGEST_S = 3e-5, 3e-4  # of L2 beside the resistance, of what motors have
POINTS = ((-math.sqrt(0.6), 5 / 18), (0.0, 8 / 18), (math.sqrt(0.6), 5 / 18))
"""Of a uniform variable between -1 and 1, with their weights."""


def _with(point: float) -> ShareOfInductance:
    """The share at a time constant between the shortest (-1) and the longest (1)."""
    middle = math.sqrt(SHORTEST_S * LONGEST_S)
    time_s = middle * (LONGEST_S / middle) ** point
    return ShareOfInductance("eddy", "eddy_time", lambda _: time_s)


EDDY_CURRENTS = InfluenceQuantity(
    name="eddy currents",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.UNDETECTED,
    acts=(_with(0.0),),
    prior=usual(USUAL),
    scale=scales.one,
    remedy="sample the current faster, or measure L apart (--fix L)",
    step=1e-4,
    term="eddy",
    shapes=tuple(Shape(chance, (_with(point),)) for point, chance in POINTS),
)
