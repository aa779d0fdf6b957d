"""An uncertainty without what effects that were not found leave open of a value."""

from __future__ import annotations

import math

from motorid.estimate.effects.influence_quantity import Use
from motorid.estimate.effects.registry import used
from motorid.estimate.results.estimate import Estimate


def without_effects(estimate: Estimate, name: str) -> float:
    """Of a parameter (its unit): readings and chain alone."""
    total = estimate.parameters[name].total
    assert total is not None
    lines = estimate.budget[name]
    open_of = [lines.get(quantity.name, 0.0) for quantity in used(Use.UNDETECTED)]
    return math.sqrt(total**2 - sum(u**2 for u in open_of))
