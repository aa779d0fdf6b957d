"""One objective for every method: how far a candidate motor's response is from the readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motorid.estimate.results.estimate import Floats
from motorid.motor.batch import Model, Record
from motorid.search.bounds import Box

Expand = Callable[[Floats], Floats]  # searched values (n, d) -> the model's parameters (n, p)


def peaks(records: Sequence[Record]) -> dict[str, float]:
    """Largest magnitude of each channel: dividing by it makes amperes and rad/s comparable."""
    largest: dict[str, float] = {}
    for record in records:
        for name, y in record.measured.items():
            largest[name] = max(largest.get(name, 0.0), float(np.nanmax(np.abs(y))))
    return largest


@dataclass(frozen=True)
class Objective:
    """Cost of points of the unit cube; ``box`` gives them units, ``expand`` the other parameters.

    ``scale``: residuals of each channel are divided by it. ``rms``: the cost is the root mean
    square over all readings of all records, else the root of the plain sum (equation 31 of the
    review, whose weights are 1/scale).
    """

    model: Model
    records: tuple[Record, ...]
    box: Box
    scale: Mapping[str, float]
    expand: Expand | None = None
    rms: bool = True

    def values(self, u: Floats) -> Floats:
        """The model's parameters in SI, (n, p), of points (n, d) of the cube."""
        physical = self.box.physical(np.atleast_2d(u))
        return self.expand(physical) if self.expand else physical

    @cached_property
    def readings(self) -> int:
        """Number of readings compared."""
        measured = [y for record in self.records for y in record.measured.values()]
        return int(sum(np.count_nonzero(~np.isnan(y)) for y in measured))

    def __call__(self, u: Floats) -> Floats:
        values, total = self.values(u), np.zeros(len(u))
        with np.errstate(over="ignore"):  # an unstable candidate may leave the doubles
            for record in self.records:
                squares = self.model.squares(values, record) / self._scales(record) ** 2
                total = total + squares.sum(axis=1)
        return np.asarray(np.sqrt(total / self.readings if self.rms else total))

    def residuals(self, u: Floats) -> Floats:
        """Scaled differences of every reading, (n, readings): the cost is their rms."""
        values, parts = self.values(u), []
        for record in self.records:
            measured = np.array(list(record.measured.values()))
            difference = self.model.outputs(values, record) - measured
            scaled = difference / self._scales(record)[:, None]
            parts.append(scaled[:, ~np.isnan(measured)])
        return np.hstack(parts)

    def _scales(self, record: Record) -> Floats:
        return np.array([self.scale[name] for name in record.channels])
