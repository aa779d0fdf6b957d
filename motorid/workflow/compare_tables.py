"""A table of the review, rebuilt: every row over many seeds, on all cores, resumable."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorid.estimate.review import remarks, tables
from motorid.estimate.review.experiment import Experiment, Row
from motorid.estimate.review.run import Summary, run, summarise
from motorid.estimate.search.problem import Solution
from motorid.workflow.tasks import Progress, Result, Task, run_all

SEEDS = 30
HISTORY_POINTS = 60  # kept of a run's convergence


@dataclass(frozen=True)
class Line:
    """One row of one experiment at one noise: its summary and its convergence.

    ``convergence`` (m, 2): evaluations, median over the seeds of the best cost so far.
    """

    row: Row
    summary: Summary
    convergence: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Block:
    """One experiment at one noise."""

    experiment: Experiment
    noise: float
    lines: tuple[Line, ...]


@dataclass(frozen=True)
class TableResult:
    """One table, rebuilt, with the sentences on its printed figures."""

    number: int
    seeds: int
    blocks: tuple[Block, ...]
    remarks: tuple[str, ...]


def compare_table(
    number: int,
    folder: Path,
    *,
    seeds: int = SEEDS,
    jobs: int = -1,
    progress: Progress | None = None,
) -> TableResult:
    """Rebuild table ``number``; ``folder`` keeps each run. Raises UsageError outside 2 to 9."""
    places = [
        (experiment, noise, index, row)
        for experiment in tables.table(number)
        for noise in experiment.noise
        for index, row in enumerate(experiment.rows)
    ]
    tasks = [
        Task(_work, (number, e.key, index, noise, seed), _definition(e, row, noise, seed))
        for e, noise, index, row in places
        for seed in range(seeds)
    ]
    results = run_all(tasks, folder, jobs, progress)
    lines: dict[tuple[str, float], list[Line]] = {}
    for place, (experiment, noise, _, row) in enumerate(places):
        runs = [solution_of(r) for r in results[place * seeds : (place + 1) * seeds]]
        summary = summarise(experiment, row, noise, runs)
        line = Line(row, summary, median_convergence(runs))
        lines.setdefault((experiment.key, noise), []).append(line)
    by_key = {experiment.key: experiment for experiment, *_ in places}
    blocks = tuple(Block(by_key[key], noise, tuple(ls)) for (key, noise), ls in lines.items())
    return TableResult(number, seeds, blocks, remarks.remarks(number))


def _definition(experiment: Experiment, row: Row, noise: float, seed: int) -> dict[str, Any]:
    searched = {k: v for k, v in asdict(row).items() if k not in ("label", "printed", "percent")}
    return {
        "experiment": experiment.key,
        "truth": dict(experiment.truth),
        "model": experiment.model.name,
        "made_by": (experiment.truth_model or experiment.model).name,
        "refine": experiment.refine,
        "input": [float(x) for x in experiment.input[:: max(len(experiment.input) // 64, 1)]],
        "period_s": experiment.period_s,
        "low": experiment.box.low.tolist(),
        "high": experiment.box.high.tolist(),
        "noise": noise,
        "seed": seed,
        **searched,
    }


@cache
def _experiments(number: int) -> Mapping[str, Experiment]:
    return {experiment.key: experiment for experiment in tables.table(number)}


def _work(number: int, key: str, index: int, noise: float, seed: int) -> Result:
    experiment = _experiments(number)[key]
    return result_of(run(experiment, experiment.rows[index], noise, seed))


def result_of(solution: Solution) -> Result:
    """A solution as plain data, its convergence thinned."""
    data = asdict(solution)
    history = solution.history
    kept = np.unique(np.geomspace(1, max(len(history), 1), HISTORY_POINTS).astype(int) - 1)
    data["history"] = history[kept].tolist() if len(history) else []
    data["cost"] = solution.cost if math.isfinite(solution.cost) else None
    return data


def solution_of(result: Result) -> Solution:
    """What ``result_of`` wrote."""
    cost = math.nan if result["cost"] is None else result["cost"]
    history = np.array(result["history"], dtype=np.float64).reshape(-1, 2)
    return Solution(**{**result, "cost": cost, "history": history})


def median_convergence(runs: list[Solution]) -> tuple[tuple[float, float], ...]:
    """Median best cost against evaluations, (m, 2), over runs that have a history."""
    histories = [run.history for run in runs if len(run.history) > 1]
    if not histories:
        return ()
    first = max(h[0, 0] for h in histories)
    last = max(h[-1, 0] for h in histories)
    if not last > first:
        return ()
    grid = np.geomspace(first, last, HISTORY_POINTS)
    best = [h[np.searchsorted(h[:, 0], grid * (1 + 1e-12), side="right") - 1, 1] for h in histories]
    return tuple(zip(grid.tolist(), np.median(best, axis=0).tolist(), strict=True))
