"""Score test: how far each hypothesis would lower the misfit, from the fit's own derivatives.

The change d of the readings that a fault of some size makes is cleared of all that parameters and
nuisances explain, as the residuals r are already. What is left, d', explains (d'r)²/(d'd') of the
squared residuals, in white noise of unit variance. Of several sizes the best counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.algebra import dot, gram, project, square
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.estimate.suspects.hypothesis import Hypothesis, Size
from motorid.estimate.uncertainty import covariance_of

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Score:
    """A hypothesis at its best size: ``gain`` is the chi-square that it would explain."""

    hypothesis: Hypothesis
    size: Size
    gain: float


class Screen:
    """The fit's derivatives, made ready for many hypotheses."""

    def __init__(self, records: Sequence[MotorRecord], solution: Solution) -> None:
        self.records, self.solution = records, solution
        self._inverse = covariance_of(solution.information)
        self._own = [
            np.linalg.pinv(gram(line.own.T, line.own.T) + np.diag(line.own_precision))
            for line in solution.records
        ]

    def best(self, hypothesis: Hypothesis) -> Score:
        """The size that explains most."""
        return max((self._score(hypothesis, s) for s in hypothesis.sizes), key=lambda s: s.gain)

    def _score(self, hypothesis: Hypothesis, size: Size) -> Score:
        lines, changes = self.solution.records, self._changes(hypothesis, size)
        pull = sum(
            (project(line.orthogonal.T, d) for line, d in zip(lines, changes, strict=True)),
            np.zeros(len(self._inverse)),
        )
        length = sum(square(d) for d in changes) - float(pull @ self._inverse @ pull)
        slope = sum(
            (project(line.orthogonal.T, line.residual) for line in lines),
            np.zeros(len(self._inverse)),
        )
        along = sum(dot(d, line.residual) for line, d in zip(lines, changes, strict=True))
        along -= float(pull @ self._inverse @ slope)
        signed = hypothesis.lower[0] < 0
        if not length > 0 or (along <= 0 and not signed):
            return Score(hypothesis, size, 0.0)
        # a lone size is a unit to be scaled; of several, each stands for itself
        scaled = (size[0] * along / length, *size[1:]) if len(hypothesis.sizes) == 1 else size
        bounded = np.clip(scaled, hypothesis.lower, hypothesis.upper)
        return Score(hypothesis, tuple(bounded.tolist()), along**2 / length)

    def _changes(self, hypothesis: Hypothesis, size: Size) -> list[Floats]:
        """Of every record's weighed readings, cleared of its own nuisances."""
        out = []
        values, tried = self.solution.values, np.array(size)
        for k, (record, line) in enumerate(zip(self.records, self.solution.records, strict=True)):
            parts = record.weighed(hypothesis.effect(record, values, self.solution.own[k], tried))
            change = np.concatenate([d / s for d, s in zip(parts, line.sigmas, strict=True)])
            shift = self._own[k] @ project(line.own.T, change)
            out.append(change - np.einsum("mn,m->n", line.own.T, shift))
        return out
