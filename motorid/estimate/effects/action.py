"""What a record's own unknowns change of its response: voltages, times, the start of a coast."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.registry import Nuisances
from motorid.estimate.signals.time_grid import Part

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Changes:
    """``volts`` are added in every part, ``kicks`` (rad/s) to the speed at every coast's start.

    ``late``: by how much a log's voltage is (s), then each of its jumps (share of what hides it).
    ``current_late`` (s): by how much the readings of the current are, beyond what is declared.
    """

    volts: tuple[float, ...]
    kicks: tuple[float, ...]
    late: tuple[float, ...]
    current_late: float

    @classmethod
    def of(cls, unknowns: Nuisances, own: Floats, parts: int) -> Changes:
        """Those of a record's ``own`` values (SI), in so many parts of its program."""
        volts = [-unknowns.of(own, "voltage_offset")] * parts
        for k, place in unknowns.levels.items():
            volts[k] += float(own[place])
        return cls(
            tuple(volts),
            tuple(float(own[place]) for place in unknowns.coasts.values()),
            (unknowns.of(own, "voltage_late"), *(float(own[place]) for place in unknowns.jumps)),
            unknowns.of(own, "current_late"),
        )

    @property
    def key(self) -> tuple[float, ...]:
        """By which equal ones are known."""
        return (*self.volts, *self.kicks, *self.late, self.current_late)

    def over(self, parts: Sequence[Part]) -> Floats | float:
        """``volts`` in every interval, (count,); one figure where all are equal."""
        if len(set(self.volts)) == 1:
            return self.volts[0]
        return np.repeat(self.volts, [part.stop - part.start for part in parts])
