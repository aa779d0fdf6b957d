"""Noise of the voltage where its readings drive the fit: just after a step, and in a slope.

An error in the input leaves its mark on current and motion alike, where no residual shows it.
``uncertainty.errors_in_variables`` has the independent errors of every part.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use, undeclared

VOLTAGE_NOISE = InfluenceQuantity(
    name="voltage noise",
    unit="V",
    scope=Scope.PART,
    use=Use.PROPAGATED,
    acts=(),
    prior=undeclared,
    scale=scales.volts,
    remedy="measure the voltage with less noise, or hold each level longer",
)
