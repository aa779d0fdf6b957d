"""The temperatures and coefficients by which R and K as run become R and K at 25 °C.

They act on no reading: ``uncertainty.reference_temperature`` has their sizes.
"""

from __future__ import annotations

from motorid.estimate.effects import scales
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Use, undeclared


def _quantity(name: str, unit: str, remedy: str) -> InfluenceQuantity:
    return InfluenceQuantity(
        name, unit, Scope.MOTOR, Use.PROPAGATED, (), undeclared, scales.one, remedy
    )


AMBIENT_TEMPERATURE = _quantity(
    "ambient temperature", "K", "give the ambient and its uncertainty (rig file, or --ambient)"
)
SELF_HEATING = _quantity(
    "self-heating", "K", "state the motor's thermal figures in the rig file's [thermal]"
)
COPPER_COEFFICIENT = _quantity("copper coefficient", "1/K", "measure nearer to 25 °C")
MAGNET_COEFFICIENT = _quantity("magnets' coefficient", "1/K", "measure nearer to 25 °C")
