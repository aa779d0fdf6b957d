"""What the voltage of a log hides between its readings, as the residuals of its stretches show it.

A step between two readings came at a moment that no stamp tells, and noise of the readings drove
the model: both leave residuals in bursts, that no spectrum of the whole describes. Stretches of the
log stand in for runs: how their scores scatter is the scores' covariance, whatever made them.

After every step the same may be left, so that no stretch pulls: a bridge that switches, a shape of
the voltage that nobody knows. Then the readings that tell L count by what they are left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty import uneven_residuals
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

STRETCHES = 32  # of a log


def shifts(solution: Solution, records: Sequence[MotorRecord]) -> list[Floats]:
    """By how much the logs' stretches pull the parameters beyond white noise, (p,) each.

    In search coordinates, one for each direction in which they do, independent of each other.
    """
    logs = [
        (record, line)
        for record, line in zip(records, solution.records, strict=True)
        if record.sensed.waveform is not None
    ]
    if not logs:
        return rivals(solution, records[0])
    inverse = covariance_of(solution.information)
    pulls = np.concatenate([_pulls(record, line) for record, line in logs])
    white = np.asarray(sum(line.orthogonal.T @ line.orthogonal for _, line in logs))
    hidden = uneven_residuals.ways(inverse @ (pulls.T @ pulls - white) @ inverse)
    alone = uneven_residuals.shifts([line for _, line in logs], inverse, hidden)
    return [*hidden, *alone, *rivals(solution, logs[0][0])]


def rivals(solution: Solution, record: MotorRecord, friction: bool = False) -> list[Floats]:
    """Distance to the answers by another shape or delay of the voltage, by how likely those are; or
    to those by ``friction`` of another kind.
    """
    logs = np.array([u.log for u in solution.unknowns])
    out = []
    for rival in (one for one in record.rivals if one.friction is friction):
        likely = np.exp(-0.5 * rival.behind)
        ratio = np.maximum(rival.values, 1e-300) / np.maximum(solution.values, 1e-300)
        apart = np.where(logs, np.log(ratio), rival.values - solution.values)
        out.append(apart * np.sqrt(likely / (1.0 + likely)))
    return out


def _pulls(record: MotorRecord, line: Linearised) -> Floats:
    """Scores (STRETCHES, p) of a log's stretches, all channels together."""
    total = np.zeros((STRETCHES, line.orthogonal.shape[1]))
    for m, part in zip(record.measured, line.slices, strict=True):
        rows = line.orthogonal[part] * line.residual[part][:, None]
        ticks = m.keep[len(m.keep) - len(rows) :]  # a filter takes the first few
        np.add.at(total, ticks * STRETCHES // record.timeline.count, rows)
    return total
