"""The joint output-error maximum-likelihood fit of captures of one driven motor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import Capture
from motorid.estimate.effects import scales
from motorid.estimate.effects.brush_and_heating import lossless
from motorid.estimate.fit import (
    sign_check,
    start_values,
    start_values_without_motion,
    subsample_inductance,
)
from motorid.estimate.fit.alternating_fit import again
from motorid.estimate.fit.lagging_start import Doubt, taken_earlier
from motorid.estimate.fit.logs import log_fit, log_friction, log_grid
from motorid.estimate.fit.multistart import leaves_misfit, settled, whitened, with_repeated
from motorid.estimate.fit.parameter_bounds import held_values, merged, searched
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.unexplained import unsupported
from motorid.estimate.solver.problem import Solution

SHARED = (0.2, 0.8)  # of the friction at the highest speed, that is Coulomb's
SURELY = 0.5  # of chi-square: less is no better
FINE = 1e-4  # the same at the end of a fit of logs: how their parts pull is read off it
FINE_STEPS = 5  # to it: what no log tells would creep
TRIED = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)  # of a motion's lag by the start values


def solved(
    captures: Sequence[Capture],
    fix: Mapping[str, float],
    without: Sequence[str],
    begin: Mapping[str, float] | None = None,
) -> tuple[list[MotorRecord], Solution]:
    """The captures as the likelihood sees them, and their most likely parameters; as ``fit``.

    ``begin``: all parameters, where the search begins; None: where the readings say.
    """
    fixed = held_values(fix, without)
    free = searched(fixed)
    if fixed.get("L") == 0.0:  # the rise of the current would be taken for a drop
        captures = [lossless(capture) for capture in captures]
    records = [MotorRecord(capture, free, fixed) for capture in captures]
    if begin is None:
        sign_check.insist(records)
    start, doubt = _begun(records, fixed) if begin is None else (dict(begin), None)
    solution = settled(records, free, start)
    logged = any(record.sensed.waveform for record in records)
    if logged:  # a channel that is late by many samples leaves as much
        records, solution = log_fit.best(records, solution, free, start, fixed)
    if doubt is not None:  # a motion that is late, before it is refused
        records, solution = _doubted(records, solution, free, start, fixed, doubt)
    if unsupported(records, solution) is not None:
        return records, solution  # no colour of the noise explains so much
    if logged:
        records, solution = log_grid.settled((records, solution), free, start, fixed)
    solution = ended(records, solution, free, start, logged)
    known = merged(start, solution)
    return subsample_inductance.told(records, free, fixed, known, solution) or (records, solution)


def ended(
    records: Sequence[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    logged: bool,
) -> Solution:
    """A search in white noise carried to its end: with what repeats, in the noise that it shows."""
    if logged:
        solution = _with_other_friction(records, solution, free, start)
    solution = with_repeated(records, free, start, solution)
    solution = whitened(records, free, merged(start, solution), solution)
    if not logged:
        return solution
    fine = again(records, free, start, solution, FINE, most=FINE_STEPS)
    return replace(fine, converged=solution.converged or fine.converged)


def _begun(
    records: Sequence[MotorRecord], fixed: Mapping[str, float]
) -> tuple[dict[str, float], Doubt | None]:
    """Where the search begins, and why that is a guess."""
    if start_values_without_motion.suits(records, fixed):
        return start_values_without_motion.start_values(records, fixed), None
    return start_values.begun(records, fixed)


def _with_other_friction(
    records: Sequence[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
) -> Solution:
    """The likelier of this solution, and those that share friction otherwise between B and T0.

    One level hardly separates the two. A T0 near nothing lets noise of the voltage turn a resting
    motor, which is a valley of its own for a search.
    """
    if not {"B", "T0"} <= set(free):
        return solution
    found = merged(start, solution)
    top = max(scales.speed(record) for record in records)
    if not top:
        return log_friction.shared(records, solution, free, start)
    torque = found["B"] * top + found["T0"]
    for share in SHARED:
        other = {**found, "B": (1.0 - share) * torque / top, "T0": share * torque}
        near = replace(solution, values=np.array([other[u.name] for u in solution.unknowns]))
        trial = again(records, free, start, near)
        if trial.objective < solution.objective - SURELY:
            solution = trial
    return solution


def _doubted(
    records: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fixed: Mapping[str, float],
    doubt: Doubt,
) -> tuple[list[MotorRecord], Solution]:
    """The likelier of the captures as they are, and with a motion that is taken earlier.

    Raises DataError where neither fits well; what no motor gives is for the refusal to say.
    """
    best = records, solution
    for share in TRIED if doubt.late_s > 0.0 else ():
        captures = [taken_earlier(record.capture, share * doubt.late_s) for record in records]
        others = [
            MotorRecord(capture, free, fixed, record.shape)
            for capture, record in zip(captures, records, strict=True)
        ]
        other = settled(others, free, start)
        if other.objective < best[1].objective:
            best = others, other
    if leaves_misfit(best[1], best[0]) and unsupported(*best) is None:
        raise doubt.refusal()
    return best
