"""The fit again with a fault that was convicted among its unknowns: what is named is allowed for.

A fault that has a size is a quantity as any other (VIM 2.52): its size is estimated with the motor,
and what is left open of it is in the intervals. The fault is named all the same, with the values of
the fit that takes the channels as stated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from motorid.errors import DataError
from motorid.estimate.diagnosis import misfit, rank
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.fit.multistart import settled, whitened
from motorid.estimate.fit.parameter_bounds import held_values, merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Suspect
from motorid.estimate.solver.problem import Solution, Unknown


@dataclass(frozen=True)
class Repaired:
    """The captures with a fault among their unknowns, and what is said of it."""

    records: list[MotorRecord]
    solution: Solution
    suspect: Suspect


def repaired(
    records: Sequence[MotorRecord],
    solution: Solution,
    convicted: rank.Convicted | None,
    fix: Mapping[str, float],
    without: Sequence[str],
) -> Repaired | None:
    """None where there is no such fault, or the fit with it leaves as much to explain as a fault.

    ``fix`` and ``without`` as of a fit.
    """
    if convicted is None or convicted.trial.hypothesis.quantity is None:
        return None
    held = held_values(fix, without)
    free = [name for name in PARAMETERS if name not in held]
    again = [record.twin() for record in records]
    for record in again:
        record.whiten([None] * len(record.measured))  # the noise's colour was the fault's
    for k in convicted.records:
        _let_find(again[k], convicted.trial)
    before = merged(held, solution)
    start = _where_the_trial_ended(before, convicted.trial, solution)
    try:
        found = settled(again, free, start)
        found = whitened(again, free, merged(start, found), found)
    except DataError:
        return None  # the fault stays named, and what it may have moved stays doubtful
    left = misfit.excess(again, misfit.residuals(again, found))
    if not found.converged or left > rank.LIKELY:
        return None
    return Repaired(again, found, _allowed(convicted.suspect, before))


def _where_the_trial_ended(
    before: Mapping[str, float], trial: rank.Trial, solution: Solution
) -> dict[str, float]:
    names = (unknown.name for unknown in solution.unknowns)
    return {**before, **dict(zip(names, map(float, trial.found.values), strict=True))}


def _let_find(record: MotorRecord, trial: rank.Trial) -> None:
    """The fault is an unknown of the record, known to be there, of about the trial's size."""
    hypothesis, size = trial.hypothesis, float(trial.found.size[0])
    assert hypothesis.quantity is not None
    (scale,), (lower,), (upper,) = hypothesis.scale, hypothesis.lower, hypothesis.upper
    one = Instance(hypothesis.quantity)
    record.find({one: Unknown(one.name, size, lower, upper, scale=scale, prior_sd=abs(size))})


def _allowed(suspect: Suspect, before: Mapping[str, float]) -> Suspect:
    return replace(
        suspect,
        evidence=f"{suspect.evidence}; the fit allows for it",
        moves={},
        allowed=True,
        without=before,
    )
