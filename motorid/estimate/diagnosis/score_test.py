"""Score test: how far each hypothesis would lower the misfit, from the fit's own derivatives.

The change d of the readings that a fault of some size makes is cleared of all that parameters and
nuisances explain. What is left, d', lowers the squared residuals of each kind of reading; F falls
by n log of that. The noise is taken as white, whatever the fit made of it: a fit that has weighed
a misfit down would see little of its cause. Of several sizes the best counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.fit.block_regression import Size
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.dense_products import dot, project, square
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

TINY = 1e-9


@dataclass(frozen=True)
class Score:
    """A hypothesis at its best size: ``gain`` is how far F would fall."""

    hypothesis: Hypothesis
    size: Size
    gain: float


class Screen:
    """The fit's derivatives in white noise, made ready for many hypotheses."""

    def __init__(self, records: Sequence[MotorRecord], solution: Solution) -> None:
        self.records, self.solution = records, plain(records, solution)
        self._inverse = covariance_of(self.solution.information)
        self._own = [np.linalg.pinv(line.own_information) for line in self.solution.records]
        lines = self.solution.records
        own = [self._less_own(k, line.residual) for k, line in enumerate(lines)]
        self._rest = self._less_shared(own)  # residuals that nothing in the model would explain
        self._squares = self._by_kind(self._rest)

    def best(self, hypothesis: Hypothesis) -> Score:
        """The size that explains most."""
        return max((self._score(hypothesis, s) for s in hypothesis.sizes), key=lambda s: s.gain)

    def _score(self, hypothesis: Hypothesis, size: Size) -> Score:
        changes = self.of(hypothesis, size)
        length = sum(square(d) for d in changes)
        along = sum(dot(d, r) for d, r in zip(changes, self._rest, strict=True))
        if not length > 0 or (along <= 0 and hypothesis.lower[0] >= 0):
            return Score(hypothesis, size, 0.0)
        factor = float(along / length)
        after = self._by_kind([r - factor * d for r, d in zip(self._rest, changes, strict=True)])
        gain = sum(
            n * float(np.log(max(before, TINY) / max(after[kind][1], TINY)))
            for kind, (n, before) in self._squares.items()
        )
        # a lone size, or one at a place, is a unit to be scaled; of several, each stands for itself
        unit = len(hypothesis.sizes) == 1 or hypothesis.place is not None
        scaled = (size[0] * factor, *size[1:]) if unit else size
        bounded = np.clip(scaled, hypothesis.lower, hypothesis.upper)
        return Score(hypothesis, tuple(bounded.tolist()), gain)

    def of(self, hypothesis: Hypothesis, size: Size | Floats) -> list[Floats]:
        """What a fault changes of every record's readings, ``cleared``."""
        values, tried, own = self.solution.values, np.array(size), self.solution.own
        return self.cleared(
            [hypothesis.effect(r, values, own[k], tried) for k, r in enumerate(self.records)]
        )

    def cleared(self, effects: Sequence[Sequence[Floats]]) -> list[Floats]:
        """Changes (n,) of every record, in standard deviations, less what nuisances and parameters
        make of them; ``effects``: SI, by channel.
        """
        changes = []
        for k, (record, effect) in enumerate(zip(self.records, effects, strict=True)):
            parts = record.weighed(effect, filtered=False)
            sigmas = self.solution.records[k].sigmas
            change = np.concatenate([d / s for d, s in zip(parts, sigmas, strict=True)])
            changes.append(self._less_own(k, change))
        return self._less_shared(changes)

    def _less_own(self, k: int, change: Floats) -> Floats:
        line = self.solution.records[k]
        shift = self._own[k] @ project(line.own.T, change)
        return np.asarray(change - np.einsum("mn,m->n", line.own.T, shift))

    def _less_shared(self, changes: list[Floats]) -> list[Floats]:
        lines = self.solution.records
        pull = sum(
            (project(line.orthogonal.T, d) for line, d in zip(lines, changes, strict=True)),
            np.zeros(len(self._inverse)),
        )
        shift = self._inverse @ pull
        return [
            np.asarray(d - np.einsum("pn,p->n", line.orthogonal.T, shift))
            for line, d in zip(lines, changes, strict=True)
        ]

    def _by_kind(self, residuals: list[Floats]) -> dict[str, tuple[float, float]]:
        """Readings, and sum of squares, of each kind of reading."""
        out: dict[str, tuple[float, float]] = {}
        for line, r in zip(self.solution.records, residuals, strict=True):
            for block, part in zip(line.blocks, line.slices, strict=True):
                n, total = out.get(block.group or block.name, (0.0, 0.0))
                out[block.group or block.name] = n + block.count, total + square(r[part])
        return out
