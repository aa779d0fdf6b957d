"""What a solution for one driven motor says: the estimate with its uncertainty, and its remarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motorid import __version__
from motorid.capture.model import Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate.diagnosis import remarks, residual_remarks
from motorid.estimate.diagnosis.deferred import Suspects
from motorid.estimate.fit import plot_data
from motorid.estimate.fit.parameter_bounds import held_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.program_parts import by_part
from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import (
    errors_in_variables,
    instrument_budget,
    intervals,
    log_scatter,
    profile_likelihood,
    shared_causes,
)
from motorid.estimate.uncertainty.covariance import Statistical, statistical
from motorid.estimate.uncertainty.errors_in_variables import Hidden
from motorid.segment import segment

Floats = NDArray[np.float64]

MODEL = "v = R i + L di/dt + K w; J dw/dt = K i - B w - T0 sign(w)"
METHOD = "output-error maximum likelihood"
HIGH = 95  # percentile of a log's voltages that counts as its highest level
NUISANCE_UNITS = {
    "current_offset": "A",
    "position_origin": "rad",
    "voltage_offset": "V",
    "initial_speed": "rad/s",
    "initial_current": "A",
    "voltage_late": "s",
    "current_late": "s",
    "voltage_loss": "V",
    "warming": "1",
    "initial_warmth": "1",
    "cogging_phase": "rad",
    "ripple_phase": "rad",
}


def report(
    captures: Sequence[Capture],
    records: Sequence[MotorRecord],
    solution: Solution,
    fix: Mapping[str, float],
    without: Sequence[str],
    profiled: bool = True,
) -> Estimate:
    """What a solution says, whichever method found it: uncertainty from its curvature.

    ``profiled``: it is the likelihood's own minimum, so that the profile may bound what leans.
    """
    fixed = held_values(fix, without)
    simulated = max(record.simulated for record in records)
    unseen = errors_in_variables.hidden(solution, records)
    scatter = scattered(solution, records, unseen)
    found = intervals.Findings(
        solution,
        scatter,
        instrument_budget.budget(solution, records),
        fixed,
        without,
        profile_likelihood.intervals(solution, records, scatter)
        if profiled and solution.converged
        else {},
        unseen,
    )
    parameters = intervals.parameters(found)
    voltage = nominal_voltage(records)
    chi_square, freedom = residual_remarks.chi_square(solution, records)
    named = [(capture, segment(capture)) for capture in captures]
    return Estimate(
        model=MODEL,
        method=METHOD,
        parameters=parameters,
        combinations=intervals.combinations(found, parameters),
        derived=intervals.derived(found, voltage),
        nuisance=nuisance_parameters(solution, records, unseen),
        free=found.names,
        correlation=correlation(found.statistical.covariance),
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        evaluations=simulated,
        diagnostics=remarks.diagnostics(found, records, parameters, named),
        curves=plot_data.curves(solution, records),
        steady=plot_data.steady(found.motor(), [r.gear for r in records], named),
        segments=plot_data.segments(named),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": list(without), "method": "ml"},
        versions={"motorid": __version__, "numpy": np.__version__},
        budget=intervals.budget_shares(found),
        suspects=Suspects(records, solution, parameters),
    )


def scattered(
    solution: Solution, records: Sequence[MotorRecord], unseen: Sequence[Hidden]
) -> Statistical:
    """Covariance of any model's fit: with what no residual shows, and the spread of its parts."""
    kinds = (log_scatter, shared_causes)
    hidden = [shift for kind in kinds for shift in kind.shifts(solution, records)]
    hidden += errors_in_variables.shifts(unseen)
    return statistical(solution, hidden, by_part(solution, records))


def nominal_voltage(records: Sequence[MotorRecord]) -> float:
    """V, the highest steady level among the captures. Raises DataError when none was driven."""
    levels = [
        _level(record.volts[part.slice], of_log=part.kind is None)
        for record in records
        for part in record.timeline.parts
        if not part.open
    ]
    if not levels or max(levels) == 0:
        raise DataError("the motor was never driven in these captures: capture a run with a step")
    return max(levels)


def _level(volts: Floats, of_log: bool) -> float:
    """V of a part: its usual one, or the highest that a log held for a while."""
    if of_log:
        return float(np.percentile(np.abs(volts), HIGH))
    return abs(float(np.median(volts)))


def correlation(covariance: Floats) -> Floats:
    """(p, p) from a covariance; 0 where a variance is."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return np.asarray(np.clip(covariance / np.outer(scale, scale), -1.0, 1.0))


def nuisance_parameters(
    solution: Solution, records: Sequence[MotorRecord], unseen: Sequence[Hidden]
) -> dict[str, Parameter]:
    """What was estimated of each capture on the way; ``unseen``: with errors of its input."""
    out = {}
    for k, record in enumerate(records):
        label = f" of run {k + 1}" if len(records) > 1 else ""
        noise = np.diag(solution.own_covariance[k])
        deviations = np.sqrt(noise + errors_in_variables.own_variance(unseen, k, len(noise)))
        for unknown, value, sd in zip(record.unknowns, solution.own[k], deviations, strict=True):
            if unknown.name not in NUISANCE_UNITS:
                continue  # what noise left open of a voltage says nothing of the motor or its rig
            v, u = float(value), float(sd)
            reach = intervals.NORMAL_95 * u
            name = unknown.name.replace("_", " ") + label
            out[name] = Parameter(
                name, NUISANCE_UNITS[unknown.name], v, u, 0.0, u, (v - reach, v + reach),
                "estimated",
            )  # fmt: skip
    return out
