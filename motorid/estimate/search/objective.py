"""One objective for every method: how far a candidate motor's response is from the readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motorid.estimate.search.bounds import Box
from motorid.estimate.types import Floats
from motorid.motor.batch import Model, Record

Expand = Callable[[Floats], Floats]  # searched values (n, d) -> the model's parameters (n, p)


def peaks(record: Record) -> dict[str, float]:
    """Largest magnitude of each channel: dividing by it makes amperes and rad/s comparable."""
    return {name: float(np.nanmax(np.abs(y))) for name, y in record.measured.items()}


@dataclass(frozen=True)
class Objective:
    """Cost of points of the unit cube; ``box`` gives them units, ``expand`` the other parameters.

    ``scale``: residuals of each channel are divided by it. ``rms``: the cost is the root mean
    square over all readings, else the root of the plain sum (equation 31 of the review, whose
    weights are 1/scale).
    """

    model: Model
    record: Record
    box: Box
    scale: Mapping[str, float]
    expand: Expand | None = None
    rms: bool = True

    def values(self, u: Floats) -> Floats:
        """The model's parameters in SI, (n, p), of points (n, d) of the cube."""
        physical = self.box.physical(np.atleast_2d(u))
        return self.expand(physical) if self.expand else physical

    @cached_property
    def scales(self) -> Floats:
        """``scale`` in the record's order, (channels,)."""
        return np.array([self.scale[name] for name in self.record.channels])

    @cached_property
    def readings(self) -> int:
        """Number of readings compared."""
        return int(sum(np.count_nonzero(~np.isnan(y)) for y in self.record.measured.values()))

    def __call__(self, u: Floats) -> Floats:
        squares = self.model.squares(self.values(u), self.record)
        with np.errstate(over="ignore"):  # an unstable candidate may leave the doubles
            total = (squares / self.scales**2).sum(axis=1)
        return np.asarray(np.sqrt(total / self.readings if self.rms else total))

    def residuals(self, u: Floats) -> Floats:
        """Scaled differences of every reading, (n, readings): the cost is their rms."""
        outputs = self.model.outputs(self.values(u), self.record)
        measured = np.array(list(self.record.measured.values()))
        scaled = (outputs - measured) / self.scales[:, None]
        return np.asarray(scaled[:, ~np.isnan(measured)])
