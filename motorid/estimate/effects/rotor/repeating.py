"""What repeats with the rotor's angle in a capture, as its readings show it.

A quantity has two unknowns an order, in front of the cosine and of the sine of order times angle:
the rotor begins each run at an angle of its own. What they do to the readings was computed along
the fitted motion. It is a straight line in them, so no search simulates it again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import pi
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance

if TYPE_CHECKING:
    from motorid.estimate.effects.influence_quantity import Subject

Floats = NDArray[np.float64]
Courses = Mapping[str, Floats]

PHASES = (0.0, pi / 2)  # of the two unknowns of an order


@dataclass(frozen=True)
class Repeating:
    """``slopes``: what each block (n,) shows of a unit of each quantity. ``bend``: what the sizes
    that were found add beyond that straight line. ``course`` (outputs, count): what they add to the
    run by which the driving voltage is judged.
    """

    slopes: Mapping[Instance, Courses] = field(default_factory=dict)
    bend: Courses = field(default_factory=dict)
    course: Floats | float = 0.0


STEADY = Repeating()


def of_order(quantity: InfluenceQuantity, periods: int) -> tuple[Instance, Instance]:
    """Its two unknowns, by ``PHASES``, of so many periods a turn."""
    return Instance(quantity, 2 * periods), Instance(quantity, 2 * periods + 1)


def order(one: Instance) -> int:
    """Periods a turn."""
    return one.place // 2


def phase(one: Instance) -> float:
    """rad."""
    return PHASES[one.place % 2]


def orders(subject: Subject) -> Sequence[int]:
    """Places of all that a capture has."""
    return sorted({one.place for one in subject.repeating.slopes})
