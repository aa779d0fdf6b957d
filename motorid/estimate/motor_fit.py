"""The joint output-error maximum-likelihood fit of captures of one driven motor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid import __version__
from motorid.capture.model import CURRENT, Capture
from motorid.capture.store import describe
from motorid.errors import DataError
from motorid.estimate import (
    closed_form,
    colour,
    common,
    input_noise,
    instrument,
    intervals,
    log_noise,
    profile,
    remarks,
    tables,
    unseen_motion,
)
from motorid.estimate.algebra import misfits
from motorid.estimate.likelihood import ENOUGH, Solution, Unknown, maximise
from motorid.estimate.loss import lossless
from motorid.estimate.record import MotorRecord
from motorid.estimate.source import Source
from motorid.estimate.suspects import signs
from motorid.estimate.suspects.lazy import Suspects
from motorid.estimate.types import PARAMETERS, Estimate, Parameter
from motorid.estimate.uncertainty import statistical
from motorid.estimate.waveform import SHAPES, Rival
from motorid.segment import segment

Floats = NDArray[np.float64]

MODEL = "v = R i + L di/dt + K w; J dw/dt = K i - B w - T0 sign(w)"
METHOD = "output-error maximum likelihood"
SOURCE_PASSES = 3  # at most, of fit and source lines in turn
LOSS_PASSES = 7  # the same while what brushes take follows a current that still moves
SHORTEST_ELECTRICAL = 1e-3  # L/R in sample periods: below it the data know no inductance
ROUGH = 1.0  # change of chi-square that is near enough while sources and noise are unsettled
COLOUR_PASSES = 2  # of noise model and fit in turn
HIGH = 95  # percentile of a log's voltages that counts as its highest level
VANISHED = 0.02  # L/R in sample periods: less than readings tell from none
RISES, NEARBY = (0.3, 0.1), 3.0  # L/R in sample periods to begin with instead; factor
GROSS = 0.02  # residuals in units of a channel's range: worth another start
OTHER_STARTS: tuple[dict[str, float], ...] = (
    {"L": 0.2},
    {"L": 5.0},
    {"J": 0.4, "L": 2.0},
    {"J": 2.5, "R": 1.5},
)
NUISANCE_UNITS = {
    "current_offset": "A",
    "position_origin": "rad",
    "voltage_offset": "V",
    "initial_speed": "rad/s",
    "initial_current": "A",
    "voltage_late": "s",
    "voltage_loss": "V",
    "warming": "1",
    "initial_warmth": "1",
    "cogging_phase": "rad",
    "ripple_phase": "rad",
}


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


def solved(
    captures: Sequence[Capture], fix: Mapping[str, float], without: Sequence[str]
) -> tuple[list[MotorRecord], Solution]:
    """The captures as the likelihood sees them, and their most likely parameters; as ``fit``."""
    fixed = {**dict.fromkeys(without, 0.0), **fix}
    free = [name for name in PARAMETERS if name not in fixed]
    if fixed.get("L") == 0.0:  # the rise of the current would be taken for a drop
        captures = [lossless(capture) for capture in captures]
    records = [MotorRecord(capture, free, fixed) for capture in captures]
    signs.insist(records)
    begin = unseen_motion if unseen_motion.suits(records, fixed) else closed_form
    start = begin.start_values(records, fixed)
    solution = settled(records, free, start)
    if any(record.sensed.waveform for record in records):
        records, solution = _best_shaped(records, solution, free, start, fixed)
    return records, whitened(records, free, merged(start, solution), solution)


def _best_shaped(
    records: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fixed: Mapping[str, float],
) -> tuple[list[MotorRecord], Solution]:
    """Of the shapes that a log's voltage may have had between readings, the most likely.

    A voltage that jumps makes bad ground for a search, so each begins where the smoothest ended.
    """
    near = merged(start, solution)
    found = [(records, solution)]
    for shape in SHAPES[1:]:
        others = [MotorRecord(record.capture, free, fixed, shape) for record in records]
        found.append((others, settled(others, free, near)))
    records, solution = best = min(found, key=lambda one: one[1].objective)
    for record in records:
        record.rivals = tuple(
            Rival(other.values, other.objective - solution.objective)
            for _, other in found
            if other is not solution
        )
    return best


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
    fixed = {**dict.fromkeys(without, 0.0), **fix}
    simulated = max(record.simulated for record in records)
    kinds = (input_noise, log_noise, common)
    hidden = [shift for kind in kinds for shift in kind.shifts(solution, records)]
    scatter = statistical(solution, hidden)
    found = intervals.Findings(
        solution,
        scatter,
        instrument.budget(solution, records),
        fixed,
        without,
        profile.intervals(solution, records, scatter) if profiled and solution.converged else {},
    )
    parameters = intervals.parameters(found)
    voltage = nominal_voltage(records)
    chi_square, freedom = remarks.chi_square(solution, records)
    named = [(capture, segment(capture)) for capture in captures]
    return Estimate(
        model=MODEL,
        method=METHOD,
        parameters=parameters,
        combinations=intervals.combinations(found, parameters),
        derived=intervals.derived(found, voltage),
        nuisance=nuisance_parameters(solution, records),
        free=found.names,
        correlation=correlation(found.statistical.covariance),
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        evaluations=simulated,
        diagnostics=remarks.diagnostics(found, records, parameters, named),
        curves=tables.curves(solution, records),
        steady=tables.steady(found.motor(), [r.gear for r in records], named),
        segments=tables.segments(named),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": list(without), "method": "ml"},
        versions={"motorid": __version__, "numpy": np.__version__},
        budget=intervals.budget_shares(found),
        suspects=Suspects(records, solution, parameters),
    )


def solve(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float]
) -> Solution:
    """The most likely parameters: as ``settled``, then correlated noise allowed."""
    solution = settled(records, free, start)
    return whitened(records, free, merged(start, solution), solution)


def settled(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float]
) -> Solution:
    """The most likely parameters for white noise: other starts are tried where one misfits."""
    solution = with_sources(records, free, start)
    if _misfits(solution, records):
        for factors in OTHER_STARTS:
            other = {n: start[n] * factors.get(n, 1.0) for n in PARAMETERS}
            trial = with_sources(records, free, other)
            if trial.objective < solution.objective - 1.0:
                solution = trial
        solution = with_sources(records, free, merged(start, solution))
    if _vanished(solution, records):
        known = merged(start, solution)
        period = min(record.timeline.period_s for record in records)
        trials = [solution]
        for rise in RISES:
            near_h = rise * known["R"] * period
            trials.append(with_sources(records, free, {**known, "L": near_h}, near_h))
        best = merged(start, min(trials, key=lambda one: one.objective))
        solution = with_sources(records, free, best, best["L"])  # what drives it is the last one's
        solution = with_sources(records, free, merged(start, solution))
    return solution


def _vanished(solution: Solution, records: Sequence[MotorRecord]) -> bool:
    """The inductance has gone to where it is none; what the ripple does went with it."""
    values = dict(zip((u.name for u in solution.unknowns), solution.values, strict=True))
    period = min(record.timeline.period_s for record in records)
    return 0.0 < float(values.get("L", 0.0)) < VANISHED * float(values.get("R", 0.0)) * period


def _held(unknowns: list[Unknown], inductance_h: float) -> list[Unknown]:
    """The same, for a search that must not leave an inductance far behind; 0: it may."""
    if not inductance_h:
        return unknowns
    low, high = inductance_h / NEARBY, inductance_h * NEARBY
    return [replace(u, lower=low, upper=high) if u.name == "L" else u for u in unknowns]


def with_sources(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    near_h: float = 0.0,
) -> Solution:
    """The fit and what drives the motor in turn, until that stays; ``near_h`` as in ``_held``."""
    first = _held(unknowns(records, free, start), near_h)
    solution = maximise(first, records, enough=ROUGH)
    settled = True
    for n in range(1, LOSS_PASSES):
        if settled and n >= SOURCE_PASSES:
            break
        before = [record.sources for record in records]
        for record, own in zip(records, solution.own, strict=True):
            record.retake_sources(solution.values, own)
        after = [record.sources for record in records]
        settled = all(record.settled for record in records)
        if n == 1 and not settled:  # the derivatives know nothing of what is lost yet
            solution = replace(solution, derivatives=None)
        if settled and all(_same(a, b) for old, new in zip(before, after, strict=True)
               for a, b in zip(old, new, strict=True)):  # fmt: skip
            break
        solution = again(records, free, start, solution, ROUGH, near_h)
    return solution


def again(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    before: Solution,
    enough: float = ENOUGH,
    near_h: float = 0.0,
) -> Solution:
    """The search goes on from a solution, with what has changed in the records."""
    known = _held(unknowns(records, free, merged(start, before)), near_h)
    return maximise(known, records, enough=enough, before=before)


def whitened(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    solution: Solution,
) -> Solution:
    """The fit again with the memory of every kind of residual in its weights, where it has one."""
    for _ in range(COLOUR_PASSES):
        coloured = colour.whiten(records, solution)
        wandering = colour.thin(records, solution)
        if wandering:
            solution = replace(solution, derivatives=None)  # they are of readings as weighed before
        solution = again(records, free, start, solution)
        if not coloured:
            break
    return solution


def _same(a: Source | None, b: Source | None) -> bool:
    return a is b if a is None or b is None else a.near(b)


def merged(start: Mapping[str, float], solution: Solution) -> dict[str, float]:
    """Start values with the solution's where it has them."""
    found = zip(solution.unknowns, solution.values, strict=True)
    return {**start, **{u.name: float(v) for u, v in found}}


def unknowns(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float]
) -> list[Unknown]:
    """The free parameters with their bounds, scales and start values."""
    torque, speed = typical(records, start)
    period = min(record.timeline.period_s for record in records)
    scales = {"B": torque / speed, "T0": torque}
    out = []
    for name in free:
        if name in scales:
            out.append(Unknown(name, start[name], lower=0.0, scale=scales[name]))
        elif name == "L":
            least = SHORTEST_ELECTRICAL * start["R"] * period
            out.append(Unknown(name, max(start[name], 2 * least), lower=least, log=True))
        elif name not in PARAMETERS:
            out.append(records[0].unknown(name, start[name]))
        else:
            out.append(Unknown(name, start[name], lower=0.0, log=True))
    return out


def typical(records: Sequence[MotorRecord], start: Mapping[str, float]) -> tuple[float, float]:
    """A torque (N·m) and a speed (rad/s) of these captures."""
    currents, speeds = [], []
    for record in records:
        speeds.append(float(np.abs(record.volts).max()) / start["K"])
        for m in record.measured:
            if m.block.name == CURRENT:
                currents.append(float(np.median(np.abs(m.values[record.driven[m.keep]]))))
    torque = start["K"] * max(currents, default=0.0) or start["T0"] or 1.0
    return torque, max(speeds) or 1.0


def _misfits(solution: Solution, records: Sequence[MotorRecord]) -> bool:
    """Residuals that are neither noise nor small: the search ended in the wrong valley, or early.

    A little that the model lacks, such as warming between runs, is no such thing.
    """
    for record, own in zip(records, solution.own, strict=True):
        for m, left in zip(record.measured, record.departures(solution.values, own), strict=True):
            if misfits(left, GROSS * float(np.ptp(m.values))):
                return True
    return not solution.converged


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


def nuisance_parameters(solution: Solution, records: Sequence[MotorRecord]) -> dict[str, Parameter]:
    """What was estimated of each capture on the way."""
    out = {}
    for k, record in enumerate(records):
        label = f" of run {k + 1}" if len(records) > 1 else ""
        deviations = np.sqrt(np.diag(solution.own_covariance[k]))
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
