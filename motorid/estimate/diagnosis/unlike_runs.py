"""Runs that one fit takes for runs of one motor, and that are not alike.

Each run alone would have its own parameters: one step from the common ones, by its own derivatives.
Where these take most of what the common fit leaves, another motor, another load or another
temperature is in some run. What every run lacks alike, none of them takes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis import misfit
from motorid.estimate.diagnosis.refit import plain
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Linearised, Solution

Floats = NDArray[np.float64]

NOTHING = 0.03  # of misfit: readings that are left no more than noise
MOST = 0.5  # of all squares that are left: what runs of their own parameters must take
SURE = 5.0  # standard uncertainties of a difference
ALIKE = 0.005  # relative: parameters of runs that differ by less are the same
SHRUNK = 1e-3  # of what all runs tell, that stands for what a run does not
NAMED = 3  # parameters in a sentence


@dataclass(frozen=True)
class Alone:
    """A run by itself: ``step`` (p,) from the common values and ``u`` (p,) of it, in the unit of
    each; ``taken`` of its squares ``left``.
    """

    step: Floats
    u: Floats
    taken: float
    left: float


def findings(solution: Solution, records: Sequence[MotorRecord]) -> Iterator[Diagnostic]:
    """A warning with what the runs differ in; every parameter is moved by the run farthest off."""
    if len(_runs(solution, records)) < 2 or misfit.of_fit(records, solution) < NOTHING:
        return
    white = plain(records, solution)  # a fit weighs down what all readings are left alike
    runs = [_alone(lines, white) for lines in _runs(white, records)]
    if sum(run.taken for run in runs) < MOST * sum(run.left for run in runs):
        return
    names, values = [u.name for u in solution.unknowns], solution.values
    shares = np.where(solution.at_bound, 0.0, _apart(runs, values))
    order = np.argsort(-shares)[:NAMED]
    by = ", ".join(f"{_percent(shares[k])} in {names[k]}" for k in order if shares[k] > ALIKE)
    if not by:
        return
    farthest = np.abs([run.step for run in runs]).max(axis=0)
    yield Diagnostic(
        "runs_differ", "warning",
        f"each of these {len(runs)} runs suits a motor, and together they suit none: they differ "
        f"by about {by}, as of another motor, load or temperature, or of a clamp that was moved; "
        "fit them by themselves",
        dict(zip(names, farthest.tolist(), strict=True)),
    )  # fmt: skip


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if share < 1.0 else "100 % or more"


def _runs(solution: Solution, records: Sequence[MotorRecord]) -> list[list[Linearised]]:
    """The records of each capture: a log may be cut into several, which its file tells."""
    groups: dict[object, list[Linearised]] = {}
    for record, line in zip(records, solution.records, strict=True):
        of_log = record.sensed.waveform is not None
        groups.setdefault(record.capture.sha256 or of_log or id(record), []).append(line)
    return list(groups.values())


def _alone(lines: Sequence[Linearised], solution: Solution) -> Alone:
    rows = np.concatenate([line.orthogonal for line in lines])
    residual = np.concatenate([line.residual for line in lines])
    told, pull, left = rows.T @ rows, rows.T @ residual, square(residual)
    inverse = np.linalg.pinv(told + SHRUNK * solution.information, hermitian=True)
    step = inverse @ pull
    taken = float(2.0 * step @ pull - step @ told @ step)
    scatter = max(left - taken, 0.0) / max(len(residual), 1)
    u = np.sqrt(scatter * np.maximum(np.diag(inverse), 0.0))
    return Alone(step * solution.slopes, u * np.abs(solution.slopes), taken, left)


def _apart(runs: Sequence[Alone], values: Floats) -> Floats:
    """(p,): relative difference between the runs farthest apart, where it is sure; else 0.

    At most a whole: one step tells no more.
    """
    steps, each = np.array([run.step for run in runs]), np.arange(len(values))
    low, high = steps.argmin(axis=0), steps.argmax(axis=0)
    u = np.array([run.u for run in runs])
    apart = steps[high, each] - steps[low, each]
    sure = apart > SURE * np.hypot(u[high, each], u[low, each])
    share = apart / np.maximum(np.abs(values), 1e-300)
    return np.where(sure, np.minimum(share, 1.0), 0.0)
