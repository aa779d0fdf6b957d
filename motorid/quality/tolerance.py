"""A product's limits as a plan sees them: which motors come, and how well to know them."""

from __future__ import annotations

import math

from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.uncertainty.intervals import POSITIVE
from motorid.plan.motors import Range, Spread
from motorid.plan.wants import Demand, Want
from motorid.quality.limits import Limit
from motorid.quality.product import Product

RATIO = 4.0  # of a tolerance's half-width to the 95 % interval's, as gauges are chosen
TURNS = 6.0  # of steady running for what repeats with the turn, in each direction
OF_PARAMETERS = {"R_25": "R", "K_25": "K", "R": "R", "L": "L", "K": "K", "B": "B", "J": "J",
                 "T0": "T0"}  # fmt: skip
STEADY = ("direction_", "ripple_", "friction_turn", "unbalance", "brush_noise")


def demand_of(product: Product) -> Demand:
    """95 % intervals a quarter as wide as the limits, and steady turns where those are judged."""
    wants = {}
    for name, limit in product.limits.items():
        if name in OF_PARAMETERS:
            parameter = OF_PARAMETERS[name]
            low, high = _ends(limit)
            half = (high - low) / 2.0 / RATIO
            reach = (
                half / math.sqrt(max(low, 0.25 * high) * high) if parameter in POSITIVE else half
            )
            wants[parameter] = Want(parameter, reach)
    steady = any(name.startswith(STEADY) for name in product.limits)
    ordered = tuple(wants[name] for name in PARAMETERS if name in wants)
    return Demand(ordered, TURNS if steady else 0.0)


def spread_of(product: Product, otherwise: Spread) -> dict[str, Range]:
    """The motors within the limits; ``otherwise`` where only one end is limited, cut to it."""
    found = dict(otherwise)
    for name, limit in product.limits.items():
        if name in OF_PARAMETERS:
            parameter = OF_PARAMETERS[name]
            low, high = found[parameter]
            high = min(high, limit.high) if math.isfinite(limit.high) else high
            low = limit.low if math.isfinite(limit.low) else min(low, high)
            if math.isfinite(limit.low) and math.isfinite(limit.high):
                high = limit.high
            found[parameter] = (low, max(low, high))
    return found


def _ends(limit: Limit) -> tuple[float, float]:
    """Both ends of the tolerance: from nothing where only the top is limited."""
    low = limit.low if math.isfinite(limit.low) else 0.0
    return low, limit.high if math.isfinite(limit.high) else 2.0 * limit.low
