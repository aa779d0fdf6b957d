"""What drives a motor, judged again and again: the next guess from the last two.

A source that follows the model's current moves that current. So a guess that is taken as judged may
approach its end slowly, or swing about it. The change from the guess before tells by how much of a
change the next one falls short, or goes too far (Anderson's method of depth one): that is put right
beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.reconstructed_voltage import Driving
from motorid.estimate.solver.dense_products import dot, square

Floats = NDArray[np.float64]

# times the last change, that a guess goes beyond what is judged, or returns. With more ahead,
# rounding grows to hundredths of a standard deviation within twenty guesses
AHEAD, BACK = 1.0, 0.9


@dataclass
class Mixer:
    """Of one record: what was ``judged`` last, and its ``change`` (count,) in V of the source."""

    judged: Driving | None = None
    change: Floats | None = None

    def next(self, given: Driving, judged: Driving) -> Driving:
        """The next guess, of a model that was driven as ``given`` and was then ``judged``."""
        change = judged.excitation.volts - given.excitation.volts
        other, was = self.judged, self.change
        self.judged, self.change = judged, change
        if other is None or was is None:
            return judged
        grown = change - was
        total = square(grown)
        share = dot(change, grown) / total if total else 0.0
        return judged.mixed(other, min(max(share, -AHEAD), BACK))
