"""What the readings of a log say of lags and low-passes that nobody stated, before any fit of them.

By the derivatives at a solution that takes all channels as stamped: how far chi-square would fall
with those sizes as unknowns, and what is left open of them besides. Where the readings ask for
none, the second moves the parameters still: a cause of the budget.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import UNSTATED
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.solver.dense_products import gram, project
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

WORTH_IT = 0.5  # standard deviations of what is usual: less is a line of the budget


@dataclass(frozen=True)
class Told:
    """``gain`` of chi-square for ``unknowns`` more, the ``largest`` of them in standard deviations
    of what is usual.

    ``shifts`` (p,) of the parameters in search coordinates, one for each direction in which the
    sizes are open, independent of each other; ``step`` (p,): by the sizes themselves.
    """

    gain: float
    unknowns: int
    largest: float
    readings: int
    shifts: tuple[Floats, ...]
    step: Floats

    @property
    def needed(self) -> float:
        """Of chi-square, by as many more unknowns: less may be chance (Schwarz)."""
        return self.unknowns * float(np.log(max(self.readings, 2)))

    @property
    def asked_for(self) -> bool:
        """One is of some size, and worth it."""
        return self.largest > WORTH_IT and self.gain > self.needed


def told(records: Sequence[MotorRecord], solution: Solution) -> list[Told]:
    """Of every record."""
    inverse = covariance_of(solution.information)
    each = zip(records, solution.records, solution.own, strict=True)
    return [_of_record(record, line, solution.values, own, inverse) for record, line, own in each]


def _of_record(
    record: MotorRecord, line: Linearised, values: Floats, own: Floats, inverse: Floats
) -> Told:
    pairs = [(Instance(q), Instance(q).unknown(record)) for q in UNSTATED]
    known = [(one, unknown.prior_sd) for one, unknown in pairs if unknown is not None]
    if not known:
        return Told(0.0, 0, 0.0, len(line.residual), (), np.zeros(len(inverse)))
    lengths = [s.stop - s.start for s in line.slices]
    rows = np.array([
        sd * np.concatenate(record.weighed(tangent(record, values, own, one)))
        / np.repeat(line.sigmas, lengths)
        for one, sd in known
    ])  # fmt: skip
    return heard(rows, line, inverse)


def heard(rows: Floats, line: Linearised, inverse: Floats) -> Told:
    """Of changes ``rows`` (k, n) of a record's residuals, each by one standard deviation of what is
    usual of its quantity; ``inverse`` (p, p) is the parameters' covariance.
    """
    follows = np.linalg.lstsq(line.own_information, gram(line.own.T, rows), rcond=1e-14)[0]
    pull = gram(line.orthogonal.T, rows)  # (p, k)
    left = gram(rows, rows) - gram(line.own.T, rows).T @ follows - pull.T @ inverse @ pull
    score = project(rows, line.residual)
    information = left + np.eye(len(rows))
    known_by, ways = np.linalg.eigh(information)
    known_by = np.maximum(known_by, 1.0)  # by the priors alone: less is rounding
    size = ways @ ((ways.T @ score) / known_by)
    open_ways = ways.T / np.sqrt(known_by)[:, None]
    moved = inverse @ pull
    shifts = [moved @ way for way in open_ways]
    largest = float(np.abs(size).max())
    gain, readings = float(score @ size), len(line.residual)
    return Told(gain, len(rows), largest, readings, tuple(shifts), moved @ size)
