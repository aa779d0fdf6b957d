"""Many methods on the same captures: equal budgets and seeds, all cores, resumable."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from motorid.capture import store
from motorid.capture.model import Capture
from motorid.errors import DataError, UsageError, nearest
from motorid.estimate.fit.start_values import start_values
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, SIX
from motorid.identify import fit
from motorid.search import closed
from motorid.search import fit as by_name
from motorid.search.problem import Solution
from motorid.search.review.run import Quartiles
from motorid.workflow.compare_tables import median_convergence, result_of, solution_of
from motorid.workflow.tasks import Progress, Result, Task, Workers, run_all

DEFAULT = "ml"
CHOSEN = (
    "nls", "steady-state", "pattern-search", "ga", "de-rand-1-exp", "de-best-1-bin", "tlbo", "abc",
    "pso", "pso-ciw", "pso-aiwf", "pso-ci", "cuckoo", "gwo", "jaya", "pso-ci-ciw", "de-pso",
)  # fmt: skip
BUDGET, SEEDS = 3000, 10
ONCE = (DEFAULT, "steiglitz-mcbride", *closed.TITLES)  # methods without luck


@dataclass(frozen=True)
class MethodLine:
    """One method over its seeds. ``cost``: the common objective; ``values`` and ``errors`` (percent
    of the truth, where it is known) by parameter. ``failure``: why no run gave an answer.
    """

    method: str
    seeds: int
    cost: Quartiles | None
    values: Mapping[str, Quartiles]
    errors: Mapping[str, Quartiles]
    evaluations: float
    seconds: float
    convergence: tuple[tuple[float, float], ...]
    failure: str = ""


@dataclass(frozen=True)
class Comparison:
    """The default method first, then the others by their median cost."""

    captures: tuple[str, ...]
    budget: int
    seeds: int
    truth: Mapping[str, float]
    lines: tuple[MethodLine, ...]


def compare_captures(
    paths: Sequence[Path],
    folder: Path,
    *,
    methods: Sequence[str] = CHOSEN,
    budget: int = BUDGET,
    seeds: int = SEEDS,
    jobs: Workers = -1,
    truth: Mapping[str, float] | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Run every method (and the default one) over all seeds; ``folder`` keeps each run.

    Raises UsageError for an unknown method or parameter, DataError for captures that hold too
    little for any.
    """
    _check(methods, truth or {})
    captures = _load(tuple(paths))
    _objective(tuple(paths))  # says now, in one sentence, what the captures lack
    every = list(dict.fromkeys([DEFAULT, *methods]))
    places = [(m, seed) for m in every for seed in range(1 if m in ONCE else seeds)]
    hashes = [capture.sha256 for capture in captures]
    tasks = [
        Task(
            _work,
            (tuple(paths), method, budget, seed),
            {"captures": hashes, "method": method, "budget": budget, "seed": seed},
        )
        for method, seed in places
    ]
    results = run_all(tasks, folder, jobs, progress)
    runs: dict[str, list[Solution]] = {}
    for (method, _), result in zip(places, results, strict=True):
        runs.setdefault(method, []).append(solution_of(result))
    lines = [_line(method, found, truth or {}) for method, found in runs.items()]
    others = sorted(lines[1:], key=lambda line: line.cost.median if line.cost else np.inf)
    names = tuple(str(path) for path in paths)
    return Comparison(names, budget, seeds, dict(truth or {}), (lines[0], *others))


def _check(methods: Sequence[str], truth: Mapping[str, float]) -> None:
    known = (DEFAULT, *by_name.names())
    for method in methods:
        if method not in known:
            raise UsageError(
                f"there is no method {method!r} to compare{nearest(method, known)}; the methods "
                f"are {', '.join(known)}"
            )
    for name, value in truth.items():
        if name not in PARAMETERS or not value > 0:
            raise UsageError(
                f"a truth is a positive value of one of {', '.join(PARAMETERS)}, not {name}={value}"
            )


@lru_cache(maxsize=1)
def _load(paths: tuple[Path, ...]) -> tuple[Capture, ...]:
    return tuple(store.load(path) for path in paths)


@lru_cache(maxsize=1)
def _objective(paths: tuple[Path, ...]) -> tuple[Any, tuple[MotorRecord, ...], dict[str, float]]:
    """The common objective, the records and the closed form's values."""
    records = tuple(MotorRecord(capture, PARAMETERS, {}) for capture in _load(paths))
    start = start_values(records, {})
    problem = by_name.problem(records, start, PARAMETERS, "nls")
    return problem, records, start


def _work(paths: tuple[Path, ...], method: str, budget: int, seed: int) -> Result:
    problem, records, start = _objective(paths)
    captures = _load(paths)
    try:
        found = _solve(captures, records, start, method, budget, seed)
    except (DataError, UsageError) as error:
        return result_of(Solution(method, {}, np.inf, 0, 0.0, str(error), seed, np.empty((0, 2))))
    values = np.array([max(found.values[name], 0.0) for name in PARAMETERS])
    with np.errstate(divide="ignore"):  # no friction at all is the far end of a logarithm
        cost = float(problem.objective("none")(problem.box.unit(values)[None])[0])
    return {**result_of(found), "cost": cost}


def _solve(
    captures: Sequence[Capture],
    records: Sequence[MotorRecord],
    start: Mapping[str, float],
    method: str,
    budget: int,
    seed: int,
) -> Solution:
    begin = time.perf_counter()
    if method == DEFAULT:
        estimate = fit(captures, model=SIX)
        values = {name: p.value or 0.0 for name, p in estimate.parameters.items()}
        seconds = time.perf_counter() - begin
        nothing = np.empty((0, 2))
        return Solution(
            method, values, np.nan, estimate.evaluations, seconds, "settled", 0, nothing
        )
    if method in closed.TITLES:
        return closed.solve(captures, records, start, method)
    found = by_name.search(records, start, PARAMETERS, method, budget=budget, seed=seed)
    return Solution(**{**vars(found), "values": {**dict.fromkeys(PARAMETERS, 0.0), **found.values}})


def _line(method: str, runs: Sequence[Solution], truth: Mapping[str, float]) -> MethodLine:
    good = [run for run in runs if run.values]
    if not good:
        return MethodLine(method, len(runs), None, {}, {}, 0.0, 0.0, (), runs[0].reason)
    values = {name: np.array([run.values[name] for run in good]) for name in PARAMETERS}
    return MethodLine(
        method,
        len(runs),
        Quartiles.of(np.array([run.cost if run.cost == run.cost else np.inf for run in good])),
        {name: Quartiles.of(v) for name, v in values.items()},
        {name: Quartiles.of(100 * np.abs(values[name] / truth[name] - 1)) for name in truth},
        float(np.median([run.evaluations for run in good])),
        float(np.median([run.seconds for run in good])),
        median_convergence(good),
    )
