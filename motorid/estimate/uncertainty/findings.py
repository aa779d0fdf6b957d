"""All that is uncertain of a solution, together: noise, spread, instruments, profiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.source.voltage_noise import VOLTAGE_NOISE
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.program_parts import by_part
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import (
    bent_valley,
    budget,
    cogging_of_logs,
    errors_in_variables,
    log_scatter,
    profile_likelihood,
    uneven_residuals,
)
from motorid.estimate.uncertainty.covariance import SCATTER, Statistical, statistical
from motorid.estimate.uncertainty.errors_in_variables import Hidden
from motorid.estimate.uncertainty.intervals import Findings
from motorid.estimate.uncertainty.undetected import told, undetected

Floats = NDArray[np.float64]


def findings(
    records: Sequence[MotorRecord],
    solution: Solution,
    fixed: Mapping[str, float],
    without: Sequence[str],
    profiled: bool = True,
    answers: bool = True,
) -> Findings:
    """The uncertain answer of any method, its uncertainty by the curvature at the solution.

    ``profiled``: it is the likelihood's own minimum, so that the profile may bound what leans.
    ``answers``: a value will be given, so that what effects leave open of it is of use.
    """
    unseen = errors_in_variables.hidden(solution, records)
    scatter = scattered(solution, records, unseen)
    lines = undetected(solution, records, unseen) if answers else ()
    carried = budget.carried(solution, records)
    leaning = profiled and not solution.unfinished
    if leaning and (bent := bent_valley.shifts(solution, records, scatter)):
        scatter = scattered(solution, records, unseen, bent)
    return Findings(
        solution,
        scatter,
        {**budget.lines_of(carried.shared, solution, records), **told(lines)},
        fixed,
        without,
        profile_likelihood.intervals(solution, records, scatter) if leaning else {},
        lines,
        unseen,
        carried,
    )


def scattered(
    solution: Solution,
    records: Sequence[MotorRecord],
    unseen: Sequence[Hidden],
    bent: Sequence[Floats] = (),
) -> Statistical:
    """Covariance of any model's fit, cause by cause; ``bent``: shifts (p,) by no straight line."""
    hidden = {
        VOLTAGE_NOISE.name: errors_in_variables.shifts(unseen),
        SCATTER: log_scatter.shifts(solution, records),
        COGGING.name: cogging_of_logs.shifts(records, solution),
        budget.BENT: bent,
        budget.UNEVEN: uneven_residuals.of_captures(solution, records),
        budget.UNSTATED: [shift for record in records for shift in record.left_open],
        budget.SETTLING: [one for one in (records[0].unsettled,) if one is not None],
        budget.FRICTION: log_scatter.rivals(solution, records[0], friction=True),
        budget.SEARCH: [] if solution.converged or solution.left is None else [solution.left],
        budget.GRID: [one for one in (records[0].between_ticks,) if one is not None],
    }
    known = budget.of_priors(solution, records)
    return statistical(solution, known, hidden, by_part(solution, records))
