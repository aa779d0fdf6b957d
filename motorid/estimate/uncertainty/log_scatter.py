"""What the voltage of a log hides between its readings, as the residuals of its stretches show it.

A step between two readings came at a moment that no stamp tells, and noise of the readings drove
the model: both leave residuals in bursts, that no spectrum of the whole describes. Stretches of the
log stand in for runs: how their scores scatter is the scores' covariance, whatever made them.

After every step the same may be left, so that no stretch pulls: a bridge that switches, a shape of
the voltage that nobody knows. Few readings tell L then, and all others say how quiet the log is.
Where those that tell a direction are left far more than the others, each counts by what it is left
(the HC3 estimate of MacKinnon and White, 1985).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]

STRETCHES = 32  # of a log
SURE = 3.0  # standard deviations by which the readings that tell a direction must be left more
MOST = 0.9  # leverage of a reading; beyond, what it is left says nothing


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
        return _rivals(solution, records[0])
    inverse = covariance_of(solution.information)
    pulls = np.concatenate([_pulls(record, line) for record, line in logs])
    white = np.asarray(sum(line.orthogonal.T @ line.orthogonal for _, line in logs))
    hidden = _ways(inverse @ (pulls.T @ pulls - white) @ inverse)
    alone = _alone([line for _, line in logs], inverse, white, hidden)
    return [*hidden, *alone, *_rivals(solution, logs[0][0])]


def _ways(excess: Floats) -> list[Floats]:
    """Of a covariance (p, p), its independent shifts (p,) that are any."""
    sizes, ways = np.linalg.eigh(excess)
    return [way * np.sqrt(size) for size, way in zip(sizes, ways.T, strict=True) if size > 0]


def _alone(
    lines: Sequence[Linearised], inverse: Floats, white: Floats, known: Sequence[Floats]
) -> list[Floats]:
    """Shifts (p,) by what single readings are left, beyond those that are known."""
    rows = np.concatenate([line.orthogonal for line in lines])
    left = np.concatenate([line.residual for line in lines])
    moves = rows @ inverse  # of the parameters, by a unit of each reading
    leverage = np.minimum(np.einsum("np,np->n", moves, rows), MOST)
    squares = (left / (1.0 - leverage)) ** 2
    excess = moves.T @ (moves * squares[:, None]) - inverse @ white @ inverse
    for shift in known:
        excess = excess - np.outer(shift, shift)
    return [shift for shift in _ways(excess) if _told(moves, squares, shift)]


def _told(moves: Floats, squares: Floats, shift: Floats) -> bool:
    """The readings that move the parameters that way are surely left more than is usual."""
    weights = (moves @ (shift / np.linalg.norm(shift))) ** 2
    more = float(weights @ (squares - 1.0))
    return more > SURE * float(np.sqrt(2.0 * weights @ weights))


def _rivals(solution: Solution, record: MotorRecord) -> list[Floats]:
    """Distance to the answers by another shape or delay of the voltage, by how likely those are."""
    logs = np.array([u.log for u in solution.unknowns])
    out = []
    for rival in record.rivals:
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
