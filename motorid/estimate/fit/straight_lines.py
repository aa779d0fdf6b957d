"""What more unknowns of a record would explain, as far as straight lines about a solution show it.

No response is computed: the solution has the derivatives of all that is unknown already.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.autoregression import prominence
from motorid.estimate.solver.dense_products import gram, project, square
from motorid.estimate.solver.problem import Linearised
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]
Courses = Mapping[str, Floats]
Sight = Callable[[Floats], Floats]

LEAST = 1e-300


class StraightLines:
    """A record about a solution: its ``line`` there, ``inverse`` (p, p) of the information."""

    def __init__(self, record: MotorRecord, line: Linearised, inverse: Floats) -> None:
        self.record, self.line, self._inverse = record, line, inverse
        lengths = [part.stop - part.start for part in line.slices]
        self._weights = np.repeat(1.0 / line.sigmas, lengths)

    def rows(self, slopes: Mapping[Instance, Courses]) -> Floats:
        """(q, n): what each does to the readings, as the likelihood counts those."""
        rows = [self._row(courses) for courses in slopes.values()]
        return np.array(rows).reshape(len(rows), len(self.line.residual))

    def length(self, courses: Courses) -> float:
        """Of a change of the readings by block, in their standard deviations, less what all other
        unknowns explain of it.
        """
        return float(np.sqrt(square(self._cleared(self._row(courses)[None] * self._weights)[0])))

    def shift(self, courses: Courses) -> float:
        """How far a change of the readings moves a parameter, in its standard deviations."""
        pull = project(self.line.orthogonal.T, self._row(courses) * self._weights)
        return float((np.abs(self._inverse @ pull) / np.sqrt(np.diag(self._inverse))).max())

    def fitted(self, slopes: Mapping[Instance, Courses]) -> tuple[Floats, Floats]:
        """The most likely sizes (q,) of these, and the residual (n,) that they leave.

        All other unknowns follow, and the sizes' own priors count.
        """
        rows = self.rows(slopes) * self._weights
        cleared, residual = self._cleared(rows), self.line.residual
        information = gram(cleared, rows) + np.diag(self._precision(slopes))
        sizes = covariance_of(information) @ project(cleared, residual)
        return sizes, residual - np.einsum("qn,q->n", cleared, sizes)

    def _cleared(self, rows: Floats) -> Floats:
        """Changes (q, n) in standard deviations less what all other unknowns explain of them."""
        line = self.line
        known = gram(line.own.T, rows)
        follows = np.linalg.lstsq(line.own_information, known, rcond=1e-14)[0]
        moved = self._inverse @ gram(line.orthogonal.T, rows)
        cleared = rows - np.einsum("nm,mq->qn", line.own, follows)
        return np.asarray(cleared - np.einsum("np,pq->qn", line.orthogonal, moved))

    def _row(self, courses: Courses) -> Floats:
        parts = [courses.get(m.block.name, np.zeros(len(m.values))) for m in self.record.measured]
        return np.concatenate(self.record.weighed(parts))

    def _precision(self, slopes: Mapping[Instance, Courses]) -> Floats:
        unknowns = [one.unknown(self.record) for one in slopes]
        return np.array([0.0 if u is None else u.prior_sd**-2.0 for u in unknowns])


def fall(
    line: Linearised, before: Floats, after: Floats, shows: Sequence[Sight]
) -> tuple[float, float]:
    """By how much F falls from one residual (n,) of a record to another, and what its readings are
    worth: both by the colour of what is left of each block.

    ``shows``: what to look at of each block's residuals.
    """
    fallen = readings = 0.0
    for block, rows, shown in zip(line.blocks, line.slices, shows, strict=True):
        was, left = shown(before[rows]), shown(after[rows])
        share = len(left) / (rows.stop - rows.start)
        count = block.count * share / prominence(left) if len(left) else 0.0
        fallen += count * float(np.log(max(square(was), LEAST) / max(square(left), LEAST)))
        readings += count
    return fallen, readings
