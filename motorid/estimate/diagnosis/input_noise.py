"""What noise of a log's voltage leaves in the residuals: it drives the model, and is no fault.

A position adds it up: its residuals wander far beyond what neighbours differ by, and any slow fault
explains some of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.residual_remarks import declared_noise, lacking
from motorid.estimate.diagnosis.score_test import Screen
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.dense_products import dot, square
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.added_noise import noisier

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class InputNoise:
    """``changes``: of each draw, what is left of it in the residuals (n,) of every record once the
    fit has followed, in standard deviations; none where no voltage has any noise of a log's.
    """

    screen: Screen | None = None
    changes: tuple[list[Floats], ...] = ()

    @classmethod
    def of(cls, records: Sequence[MotorRecord], solution: Solution) -> InputNoise:
        """By several draws of noise as large as the readings have."""
        draws = [list(noisier(record)) for record in records]
        count = max(map(len, draws))
        if not count:
            return NONE
        screen = Screen(records, solution)
        values, at = screen.solution.values, screen.solution.own

        def left(ones: Sequence[MotorRecord]) -> list[list[Floats]]:
            return [one.departures(values, own) for one, own in zip(ones, at, strict=True)]

        usual, changes = left(records), []
        for n in range(count):
            moved = [of[n] if of else record for of, record in zip(draws, records, strict=True)]
            pairs = zip(usual, left(moved), strict=True)
            effects = [[b - a for a, b in zip(was, now, strict=True)] for was, now in pairs]
            changes.append(screen.cleared(effects))
        return cls(screen, tuple(changes))

    def variances(self) -> list[list[float]]:
        """Of every record's channels, SI: the largest of all draws; empty: there is no noise."""
        if self.screen is None:
            return []
        most = [[0.0] * len(record.measured) for record in self.screen.records]
        for change in self.changes:
            each = zip(self.screen.solution.records, most, change, strict=True)
            for line, sizes, rows in each:
                for j, (part, sigma) in enumerate(zip(line.slices, line.sigmas, strict=True)):
                    size = sigma**2 * square(rows[part]) / (part.stop - part.start)
                    sizes[j] = max(sizes[j], size)
        return most

    def share(self, hypothesis: Hypothesis, size: Floats) -> float:
        """Of a fault's ``size``, what such noise makes of it where there is none: rms of all draws.

        0: nothing, or no voltage has noise.
        """
        if self.screen is None:
            return 0.0
        shape = self.screen.of(hypothesis, size)
        length = max(sum(square(d) for d in shape), 1e-300)
        along = [
            sum(dot(d, c) for d, c in zip(shape, change, strict=True)) / length
            for change in self.changes
        ]
        return float(np.sqrt(np.mean(np.square(along))))


NONE = InputNoise()


def where_lacking(
    records: Sequence[MotorRecord], solution: Solution, left: Sequence[Sequence[Floats]]
) -> list[list[float]]:
    """``InputNoise.variances``, where residuals ``left`` would lack something without; else 0."""
    lacks = any(
        lacking(record, m, residual)
        for record, blocks in zip(records, left, strict=True)
        for m, residual in zip(record.measured, blocks, strict=True)
        if not declared_noise(m)
    )
    found = InputNoise.of(records, solution).variances() if lacks else []
    return found or [[0.0] * len(record.measured) for record in records]
