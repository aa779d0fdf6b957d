"""A search on captures under a model of more than the six parameters; uncertainty by curvature.

Each capture counts up to where the bridge first opens. The answer's residuals are linearised:
noise of each channel from its own residuals, the offset of a current and the origin of a position
free, spread between runs and correlated residuals as in every other fit (``uncertainty``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.capture.store import describe
from motorid.errors import DataError, UsageError
from motorid.estimate.assembly import assemble, plot_data
from motorid.estimate.diagnosis.data_remarks import unseen_voltage
from motorid.estimate.fit.parameter_bounds import held_values
from motorid.estimate.fit.start_values import start_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import (
    PARAMETERS,
    UNITS,
    Curve,
    Diagnostic,
    Estimate,
    Floats,
    Parameter,
)
from motorid.estimate.results.status import Status
from motorid.estimate.solver.problem import Solution as Likely
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.covariance import Statistical, statistical
from motorid.estimate.uncertainty.unstated_gains import gains_of
from motorid.motor.batch import Record
from motorid.search import captures as capture_problem
from motorid.search import models
from motorid.search.curvature import curvature, instrument, outputs
from motorid.search.models import Extended
from motorid.search.objective import peaks
from motorid.search.problem import Problem, Solution, remark, solve
from motorid.segment import segment
from motorid.version import __version__

SHORTEST = 50  # samples of a driven stretch


def fit(
    captures: Sequence[Capture],
    model: Extended,
    method: str,
    *,
    fix: Mapping[str, float],
    without: Sequence[str],
    budget: int,
    seed: int,
) -> tuple[Estimate, Solution]:
    """The model's parameters by that search. Raises UsageError for a parameter it lacks."""
    fixed = held_values(fix, without)
    _refuse(model, fixed)
    records = [MotorRecord(capture, PARAMETERS, {}) for capture in captures]
    problem = _problem(records, model, fixed)
    found = solve(problem, method, budget=budget, seed=seed, memory=True)
    likely = curvature(problem, found)
    named = [(capture, segment(capture)) for capture in captures]
    spread = statistical(likely)
    series = float(np.mean([record.sensed.series_uncertainty_ohm for record in records]))
    known = instrument(problem, found, likely, captures, series)
    parameters = _parameters(model, found, likely, spread, known)
    estimate = Estimate(
        model=model.equations,
        method=method,
        parameters=parameters,
        combinations={},
        derived={},
        nuisance={},
        free=problem.box.names,
        correlation=assemble.correlation(spread.covariance),
        chi_square=likely.chi_square,
        degrees_of_freedom=likely.degrees_of_freedom,
        evaluations=found.evaluations,
        diagnostics=(*_remarks(problem, model, found), *unseen_voltage(records)),
        curves=_curves(problem, found, likely),
        segments=plot_data.segments(named),
        inputs=tuple(describe(capture) for capture in captures),
        options={"fix": dict(fix), "without": list(without), "model": model.name},
        versions={"motorid": __version__, "numpy": np.__version__},
        not_stated={gain: {} for gain in gains_of(captures, (VOLTAGE, CURRENT, POSITION, SPEED))},
    )
    return estimate, found


def _refuse(model: Extended, fixed: Mapping[str, float]) -> None:
    for name, value in fixed.items():
        if name not in model.batch.parameters:
            raise UsageError(f"the {model.name} model has no {name} to fix or leave out")
        if name == "L" and not value:
            raise UsageError(f"the {model.name} model needs an inductance: L cannot be left out")


def _problem(
    records: Sequence[MotorRecord], model: Extended, fixed: Mapping[str, float]
) -> Problem:
    period = min(record.timeline.period_s for record in records)
    start = capture_problem.filled(start_values(records, {}), period)
    batch = tuple(_driven(record) for record in records)
    free = tuple(name for name in model.batch.parameters if name not in fixed)
    longest = max(len(record.input) for record in batch)
    box = models.box(records, start, free, longest)
    middle = dict(zip(free, np.sqrt(box.low * box.high), strict=True))
    problem = Problem(
        model.batch,
        batch,
        box,
        peaks(batch),
        start=np.array([start.get(name) or middle[name] for name in free]),
        given=dict(fixed),
        series_ohm=float(np.mean([record.sensed.series_ohm for record in records])),
    )
    return capture_problem.inside(problem)


def _driven(record: MotorRecord) -> Record:
    """The record up to where the bridge opens, from just before it is first driven."""
    parts = record.timeline.parts
    first = next((k for k, part in enumerate(parts) if not part.open), None)
    if first is None:
        raise DataError("the motor was never driven in this capture: capture a run with a step")
    end = next((part.start for part in parts[first:] if part.open), parts[-1].stop)
    begin, end = max(parts[first].start - 1, 0), end - 1
    if end - begin < SHORTEST:
        raise DataError(
            f"the bridge opens {end - begin} samples after the first step: this model needs a "
            f"driven stretch of at least {SHORTEST}"
        )
    whole = capture_problem.batch_record(record)
    cut = {name: y[begin:end] for name, y in whole.measured.items()}
    lags = dict(whole.lag_s or {})
    lags[CURRENT] = min(whole.current_delay_s + whole.current_aperture_s / 2, whole.period_s)
    return Record(whole.period_s, whole.input[begin:end], cut, None, lags)


def _parameters(
    model: Extended, found: Solution, likely: Likely, spread: Statistical, known: Floats
) -> dict[str, Parameter]:
    """The six, then what the model adds; each positive, so with an interval of its logarithm."""
    units = {**UNITS, **model.units}
    out = {}
    for name in (*PARAMETERS, *model.units):
        if name == "J" and name in model.absent:
            out[name] = _whole_inertia(found, likely, spread, known)
        elif name in model.absent:
            out[name] = Parameter(
                name, units[name], 0.0, 0.0, 0.0, 0.0, (0.0, 0.0), Status.FIXED, "not in this model"
            )
        elif name not in likely_names(likely):
            given = float(found.values[name])
            out[name] = Parameter(
                name, units[name], given, 0.0, 0.0, 0.0, (given, given), Status.FIXED,
                "given, not measured" if given else "left out of the model",
            )  # fmt: skip
        else:
            k = likely_names(likely).index(name)
            deviations = float(spread.deviations[k]), float(known[k])
            out[name] = _parameter(
                name, units[name], float(likely.values[k]), deviations,
                float(spread.freedom[k]), bool(likely.at_bound[k]),
            )  # fmt: skip
    return out


def likely_names(likely: Likely) -> tuple[str, ...]:
    """Names of the free parameters, in order."""
    return tuple(unknown.name for unknown in likely.unknowns)


def _parameter(
    name: str,
    unit: str,
    value: float,
    relative: tuple[float, float],
    freedom: float,
    at_wall: bool,
) -> Parameter:
    total = float(np.hypot(*relative))
    if at_wall or not total < intervals.UNKNOWN:
        where = "it ends at the search's bounds" if at_wall else "the cost hardly depends on it"
        return intervals.unknown(name, unit, f"these data do not determine it: {where}")
    reach = float(np.exp(intervals.student(freedom) * total))
    return Parameter(
        name, unit, value, value * relative[0], value * relative[1], value * total,
        (value / reach, value * reach), Status.ESTIMATED,
    )  # fmt: skip


def _whole_inertia(
    found: Solution, likely: Likely, spread: Statistical, known: Floats
) -> Parameter:
    """J = J1 + J2, whose errors go against each other."""
    names = likely_names(likely)
    whole = found.values["J1"] + found.values["J2"]
    gradient = np.array([found.values[n] / whole if n in ("J1", "J2") else 0.0 for n in names])
    deviation = float(np.sqrt(max(gradient @ spread.covariance @ gradient, 0.0)))
    limits = deviation, float(np.abs(gradient) @ known)
    return _parameter("J", UNITS["J"], whole, limits, float(spread.freedom.min()), False)


def _remarks(problem: Problem, model: Extended, found: Solution) -> tuple[Diagnostic, ...]:
    out = [
        remark(found),
        Diagnostic(
            "driven_part", "info",
            "the model is fitted to each capture up to where its bridge first opens",
        ),
    ]  # fmt: skip
    if "T0" in model.absent:
        out.append(
            Diagnostic(
                "linear_model", "warning",
                "this model has no Coulomb friction: B carries it, for the speeds of these runs",
            )
        )  # fmt: skip
    return tuple(out)


def _curves(problem: Problem, found: Solution, likely: Likely) -> tuple[Curve, ...]:
    units = {"current": "A", "position": "rad", "speed": "rad/s"}
    out = []
    for k, (record, line) in enumerate(zip(problem.records, likely.records, strict=True)):
        fitted = outputs(problem, record, found.values)
        for c, (name, y) in enumerate(record.measured.items()):
            time: Floats = record.period_s * np.arange(len(y), dtype=np.float64)
            out.append(Curve(k, name, units[name], time, y, fitted[c], float(line.sigmas[c])))
    return tuple(out)
