"""What a solution for one driven motor says: the estimate with its uncertainty, and its remarks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate.assembly import doubt, plot_data, untold
from motorid.estimate.assembly.measured_levels import brushes_of, measured_levels
from motorid.estimate.assembly.refusal import refused
from motorid.estimate.diagnosis import (
    rank,
    reach,
    remarks,
    repeating_remarks,
    residual_remarks,
    unlike_runs,
)
from motorid.estimate.diagnosis.facts import coasting_constant, cooling_winding, steady_levels
from motorid.estimate.diagnosis.repair import repaired
from motorid.estimate.diagnosis.suspects import suspects
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.parameter_bounds import held_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.unexplained import Unexplained, unsupported
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter, Suspect
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import errors_in_variables, intervals
from motorid.estimate.uncertainty.findings import findings
from motorid.estimate.uncertainty.intervals import Findings
from motorid.estimate.uncertainty.unstated_gains import unstated_gains
from motorid.segment import segment
from motorid.version import __version__

Floats = NDArray[np.float64]
Finding = TypeVar("Finding", Suspect, Diagnostic)

MODEL = "v = R i + L di/dt + K w; J dw/dt = K i - B w - T0 sign(w)"
METHOD = "output-error maximum likelihood"
UNCHANGED: Mapping[str, str] = {}
MOST_REPAIRS = 3  # faults that a fit allows for, one after the other
UNTOLD = 10.0  # times what a quantity is like, from which its uncertainty says nothing of it
HIGH = 95  # percentile of a log's voltages that counts as its highest level


def fit(
    captures: Sequence[Capture],
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
) -> Estimate:
    """The six parameters from captures with a voltage and a current or a motion.

    ``fix`` holds parameters at SI values; ``without`` takes L, B or T0 out of the model. Raises
    DataError where the captures cannot be fitted at all.
    """
    records, solution = solved(captures, fix or {}, without)
    return report(captures, records, solution, fix or {}, without)


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
    return answered(captures, records, solution, fix, without, profiled)[0]


def answered(
    captures: Sequence[Capture],
    records: Sequence[MotorRecord],
    solution: Solution,
    fix: Mapping[str, float],
    without: Sequence[str],
    profiled: bool = True,
) -> tuple[Estimate, Sequence[MotorRecord], Findings]:
    """``report``, with the records and the solution that it speaks of: faults may be repaired."""
    known = uncertain(records, solution, fix, without, profiled)
    found = unjudged(captures, records, known, fix, without, profiled)
    said = accused(found, records, solution, known)
    allowed: list[Suspect] = []
    for _ in range(MOST_REPAIRS if profiled and said.worst is None else 0):
        mended = repaired(records, solution, said.suspects, said.convicted, fix, without)
        if mended is None:
            break
        records, solution = mended.records, mended.solution
        captures = [record.capture for record in records]
        known = uncertain(records, solution, fix, without)
        found = unjudged(captures, records, known, fix, without)
        allowed.append(mended.suspect)
        said = accused(found, records, solution, known).after(allowed)
    return judged(found, records, solution, said, refusable=profiled), records, known


@dataclass(frozen=True)
class Accused:
    """``worst``: what the fit leaves unexplained beyond what any model does; None: nothing so bad.

    ``convicted``: the one of ``suspects`` that a fit with its size as an unknown named.
    """

    worst: Unexplained | None
    suspects: tuple[Suspect, ...]
    convicted: rank.Convicted | None

    def after(self, allowed: Sequence[Suspect]) -> Accused:
        """With faults that the fit allows for."""
        known = {one.code for one in allowed}
        others = tuple(one for one in self.suspects if one.code not in known)
        return replace(self, suspects=(*allowed, *others))


def accused(
    estimate: Estimate,
    records: Sequence[MotorRecord],
    solution: Solution,
    known: Findings | None = None,
) -> Accused:
    """What may have spoiled the captures, by what this solution leaves; ``known``: what is
    uncertain of it.
    """
    worst = unsupported(records, solution)
    if known is not None:
        solution = errors_in_variables.with_errors(solution, known.hidden)
    found, convicted = suspects(records, solution, estimate.parameters, tried=worst is None)
    return Accused(worst, found, convicted)


def judged(
    estimate: Estimate,
    records: Sequence[MotorRecord],
    solution: Solution,
    said: Accused,
    names: Mapping[str, str] = UNCHANGED,
    refusable: bool = True,
) -> Estimate:
    """With the suspects, and the standing that they and the findings leave every value.

    ``names`` of combinations that stand in the place of parameters. ``refusable``: the solution is
    the most likely one, so that what it leaves unexplained speaks of the data.
    """
    worst, found = said.worst, said.suspects
    if worst is not None and refusable:
        return refused(replace(estimate, suspects=found), worst)
    found = reach.sized(found, records, solution, estimate.parameters)
    findings = estimate.diagnostics
    if refusable or worst is not None:
        findings = reach.of_lack(findings, found, records, solution, estimate.parameters)
    estimate = replace(
        estimate,
        suspects=(*(renamed(one, names) for one in found), *estimate.suspects),
        diagnostics=tuple(renamed(one, names) for one in findings),
    )
    return doubt.settled(estimate, (*estimate.suspects, *estimate.diagnostics))


def renamed(finding: Finding, names: Mapping[str, str]) -> Finding:
    """With the moves of what stands in the place of parameters."""
    return replace(finding, moves={names.get(n, n): move for n, move in finding.moves.items()})


def uncertain(
    records: Sequence[MotorRecord],
    solution: Solution,
    fix: Mapping[str, float],
    without: Sequence[str],
    profiled: bool = True,
) -> Findings:
    """All that is uncertain of a solution."""
    simulated = max(record.simulated for record in records)
    answers, held = unsupported(records, solution) is None, held_values(fix, without)
    found = findings(records, solution, held, without, profiled and answers, answers)
    return replace(found, simulated=simulated)


def unjudged(
    captures: Sequence[Capture],
    records: Sequence[MotorRecord],
    found: Findings,
    fix: Mapping[str, float],
    without: Sequence[str],
    profiled: bool = True,
) -> Estimate:
    """``report`` before anybody has looked for suspects."""
    solution = found.solution
    parameters = intervals.parameters(found)
    voltage = nominal_voltage(records)
    chi_square, freedom = residual_remarks.chi_square(solution, records)
    named = [(capture, segment(capture)) for capture in captures]
    reached = steady_levels.levels(found, records, named)
    nuisance = nuisance_parameters(found, records)
    brushes = brushes_of(solution, records) if profiled else None  # other methods leave them out
    curves = plot_data.curves(solution, records)
    remarked = remarks.diagnostics(found, records, parameters, named)
    cools = () if reach.lacks(remarked) else cooling_winding.findings(nuisance, parameters)
    return Estimate(
        model=MODEL,
        method=METHOD,
        parameters=parameters,
        combinations=intervals.combinations(found, parameters),
        derived=intervals.derived(found, voltage, brushes),
        nuisance=nuisance,
        free=found.names,
        correlation=correlation(found.statistical.covariance),
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        evaluations=found.simulated,
        diagnostics=(
            *unlike_runs.findings(solution, records),  # before what it makes of residuals
            *remarked,
            *steady_levels.findings(reached, found.motor(), len(records)),
            *coasting_constant.findings(solution, records, parameters),
            *cools,
        ),
        curves=curves,
        steady=plot_data.steady(found.motor(), [r.gear for r in records], named, reached),
        segments=plot_data.segments(named),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": list(without), "method": "ml"},
        versions={"motorid": __version__, "numpy": np.__version__},
        budget=intervals.budget_shares(found),
        not_stated=unstated_gains(solution, records),
        nominal_v=voltage,
        brushes=brushes,
        levels=measured_levels(named, curves, found.motor(), brushes),
        repeating=repeating_remarks.repeating(records, solution),
        suspects=(
            *untold.suspects(found.undetected, solution),
            *untold.terminal_load(records, parameters),
        ),
    )


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


def nuisance_parameters(found: Findings, records: Sequence[MotorRecord]) -> dict[str, Parameter]:
    """What was estimated of each capture on the way, with what its instruments leave open of it."""
    out, solution = {}, found.solution
    for k, record in enumerate(records):
        label = f" of run {k + 1}" if len(records) > 1 else ""
        noise = np.diag(solution.own_covariance[k])
        deviations = np.sqrt(noise + errors_in_variables.own_variance(found.hidden, k, len(noise)))
        instruments = np.sqrt(found.carried.own_variance(k, len(noise)))
        known = zip(record.instances, solution.own[k], deviations, instruments, strict=True)
        for one, value, sd, carried in known:
            if not one.quantity.listed:
                continue  # what noise left open of a voltage says nothing of the motor or its rig
            v, u, instrument = float(value), float(sd), float(carried)
            if u > UNTOLD * one.quantity.scale(record):
                continue  # such as a current that is gone before the second reading
            total = math.hypot(u, instrument)
            reach = intervals.NORMAL_95 * total
            name, unit = one.name + label, one.quantity.unit
            out[name] = Parameter(
                name, unit, v, u, instrument, total, (v - reach, v + reach), Status.ESTIMATED
            )
    return out
