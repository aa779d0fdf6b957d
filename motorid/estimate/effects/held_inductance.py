"""An inductance that no reading shows, as known from what PWM does with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Foretold:
    """The inductance (H), by what it is known, and by how much each parameter's search coordinate
    moves if it is larger by one standard uncertainty.
    """

    inductance_h: float
    by: str
    shift: Mapping[str, float]
