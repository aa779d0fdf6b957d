"""``motorid fit --method NAME``: a search on captures, reported as every other fit is.

The search minimises the batch objective. Its answer then stands where the likelihood's maximum
stands in the default method: offsets and origins are made most likely for it, and uncertainties
come from the likelihood's curvature there. What the answer still leaves to gain is said.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import Capture
from motorid.errors import UsageError, nearest
from motorid.estimate.assembly.assemble import report
from motorid.estimate.diagnosis.data_remarks import unseen_voltage
from motorid.estimate.fit.parameter_bounds import searched, unknowns_of
from motorid.estimate.fit.start_values import start_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic, Estimate
from motorid.estimate.signals.log_sections import pieces
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution as Likely
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.motor.batch import LINEAR
from motorid.search import captures as capture_problem
from motorid.search import closed, extended, log_step, models, registry
from motorid.search.problem import DIRECT, ENDS, Problem, Solution, remark, solve
from motorid.search.problem import names as problem_names

BUDGET = 5000  # evaluations
PIN = 1e-9  # relative freedom of a parameter that is held
SETTLED = 1.0  # chi-square that an answer may leave to gain and still count as the minimum


def fit(
    captures: Sequence[Capture],
    method: str,
    *,
    fix: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
    budget: int = BUDGET,
    seed: int = 0,
    model: str = models.LINEAR,
) -> Estimate:
    """The six parameters by a named method; a search has at most ``budget`` evaluations.

    Delays and apertures are taken at their middle; PWM ripple and the decay of a freewheeling
    current are left out of the searched response (``captures.py``). The -m methods and
    Steiglitz-McBride use the first driven part of one capture under the linear model: there
    Coulomb friction goes into B. Another ``model`` adds its parameters (``models.py``). Raises
    UsageError for an unknown method, DataError where the captures hold too little.
    """
    if method not in names() and (method != "ml" or model == models.LINEAR):
        raise UsageError(
            f'there is no method "{method}" to fit captures by{nearest(method, names())}; the '
            f"methods are ml, {', '.join(names())}"
        )
    if model != models.LINEAR:
        return _extended(
            captures, models.get(model), method, fix or {}, without, budget=budget, seed=seed
        )
    linear = method not in closed.TITLES and _linear(method)
    if method in closed.TITLES and (fix or without):
        raise UsageError(f"{method} takes no fixed or left-out parameters: use another method")
    left_out = tuple(dict.fromkeys([*without, *(("T0",) if linear else ())]))
    fixed = {**dict.fromkeys(left_out, 0.0), **(fix or {})}
    free = searched(fixed)
    if linear and len(free) < len(LINEAR.parameters):
        raise UsageError(f"{method} takes no fixed or left-out parameters: use another method")
    captures = pieces(captures)
    records, left = _records(captures, free, fixed, method)
    captures = [record.capture for record in records]
    start = start_values(records, fixed)
    if method in closed.TITLES:
        found = closed.solve(captures, records, start, method)
    else:
        found = search(records, start, free, method, budget=budget, seed=seed)
    likely = hold(records, free, start, found)
    estimate = report(captures, records, likely, fix or {}, left_out, profiled=False)
    return replace(
        estimate,
        method=_title(method, found),
        evaluations=found.evaluations,
        diagnostics=(
            *_remarks(found, likely, linear),
            *left,
            *unseen_voltage(records),
            *estimate.diagnostics,
        ),
        options={**estimate.options, "method": method, "budget": budget, "seed": seed},
    )


def _records(
    captures: Sequence[Capture], free: Sequence[str], fixed: Mapping[str, float], method: str
) -> tuple[list[MotorRecord], list[Diagnostic]]:
    """What the method takes of the captures, and what is said of the rest: a log's first stretch
    from rest where it knows one step, and only those that begin at rest where it simulates.
    """
    records = [MotorRecord(capture, free, fixed) for capture in captures]
    if method in closed.TITLES:
        return records, []
    fair, said = log_step.begun_at_rest(records, method)
    if _linear(method) and all(log_step.is_log(record) for record in fair):
        fair = fair[:1]
    if _linear(method) and len(fair) == 1 and log_step.is_log(fair[0]):
        fair = [MotorRecord(log_step.cut_to_first_step(fair[0]), free, fixed)]
    return fair, said


def _extended(
    captures: Sequence[Capture],
    model: models.Extended,
    method: str,
    fix: Mapping[str, float],
    without: Sequence[str],
    *,
    budget: int,
    seed: int,
) -> Estimate:
    if method in closed.TITLES or _linear(method):
        raise UsageError(
            f"{method} knows the linear model only: fit {model.name} by nls or a search without -m"
        )
    estimate, found = extended.fit(
        captures, model, method, fix=fix, without=without, budget=budget, seed=seed
    )
    options = {**estimate.options, "method": method, "budget": budget, "seed": seed}
    return replace(estimate, method=_title(method, found), options=options)


def names() -> tuple[str, ...]:
    """Every method that ``fit`` takes for the six parameters; other models take ml as well."""
    return (*closed.TITLES, *(name for name in problem_names() if name != "ml"))


def _linear(method: str) -> bool:
    if method in DIRECT:
        return method == "steiglitz-mcbride"
    return registry.get(method).relations != "none"


def search(
    records: Sequence[MotorRecord],
    start: Mapping[str, float],
    free: Sequence[str],
    method: str,
    *,
    budget: int,
    seed: int,
) -> Solution:
    """The search alone; its values hold all six parameters (SI, resistance of the motor alone)."""
    return solve(
        problem(records, start, free, method),
        method,
        budget=budget,
        seed=seed,
        rule="integral",
        memory=True,
    )


def problem(
    records: Sequence[MotorRecord], start: Mapping[str, float], free: Sequence[str], method: str
) -> Problem:
    """What that method searches on those records."""
    period = min(record.timeline.period_s for record in records)
    values = capture_problem.filled(start, period)
    if not _linear(method):
        return capture_problem.inside(capture_problem.problem(records, values, free))
    if len(records) != 1:
        raise UsageError(f"{method} takes one step response: give one capture")
    return capture_problem.inside(capture_problem.step_problem(records[0], values))


def hold(
    records: Sequence[MotorRecord],
    free: Sequence[str],
    start: Mapping[str, float],
    found: Solution,
) -> Likely:
    """The likelihood at the search's answer: only offsets and origins are left to move."""
    pinned = []
    for unknown in unknowns_of(records, free, start):
        value = max(found.values[unknown.name], unknown.lower)
        room = PIN * max(abs(value), 0.0 if unknown.log else unknown.scale)
        pinned.append(replace(unknown, start=value, lower=value - room, upper=value + room))
    likely = maximise(pinned, records)
    return replace(likely, at_bound=np.zeros(len(pinned), dtype=bool), converged=True)


def newton(likely: Likely) -> tuple[float, dict[str, float]]:
    """What one Newton step from the answer takes off chi-square, and where it goes (SI)."""
    pull = sum(
        (line.orthogonal.T @ line.residual for line in likely.records),
        np.zeros(len(likely.values)),
    )
    step = covariance_of(likely.information) @ pull
    moves = step * likely.slopes
    names = (unknown.name for unknown in likely.unknowns)
    return float(pull @ step), dict(zip(names, moves.tolist(), strict=True))


def _title(method: str, found: Solution) -> str:
    if method in closed.TITLES:
        return closed.TITLES[method]
    title = method if method in DIRECT else registry.get(method).title
    return f"{title}, {found.evaluations} evaluations, seed {found.seed}"


def _remarks(found: Solution, likely: Likely, linear: bool) -> list[Diagnostic]:
    out = [remark(found)] if found.reason in ENDS else []
    gain, moves = newton(likely)
    if gain > SETTLED:
        shares = ", ".join(
            f"{name} by {100 * move / value:+.2g} %"
            for (name, move), value in zip(moves.items(), likely.values, strict=True)
            if value
        )
        out.append(
            Diagnostic(
                "not_the_minimum", "warning",
                "the search stopped short of the most likely values, and the intervals do not "
                f"include that: one step further moves {shares}; raise the budget, or use the "
                "method ml",
            )
        )  # fmt: skip
    if linear:
        out.append(
            Diagnostic(
                "linear_model", "warning",
                "this method's model has no Coulomb friction: B carries it, for the speed of "
                "the first driven part",
            )
        )  # fmt: skip
    return out
