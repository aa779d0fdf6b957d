"""A table of the review, rebuilt: every row over many seeds, on all cores, resumable."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from motorid.search.problem import Solution
from motorid.search.review import remarks, tables
from motorid.search.review.experiment import Experiment, Row
from motorid.search.review.run import Summary, run, summarise
from motorid.workflow.tasks import Progress, Result, Task, Workers, run_all

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
    jobs: Workers = -1,
    progress: Progress | None = None,
) -> TableResult:
    """Rebuild table ``number``; ``folder`` keeps each run. Raises UsageError outside 2 to 9."""
    cases = [(e, noise) for e in tables.table(number) for noise in e.noise]
    found = run_cases(cases, folder, seeds=seeds, jobs=jobs, progress=progress)
    blocks = tuple(
        Block(
            experiment,
            noise,
            tuple(
                Line(row, summarise(experiment, row, noise, runs), median_convergence(runs))
                for row, runs in zip(experiment.rows, by_row, strict=True)
            ),
        )
        for (experiment, noise), by_row in zip(cases, found, strict=True)
    )
    return TableResult(number, seeds, blocks, remarks.remarks(number))


def run_cases(
    cases: Sequence[tuple[Experiment, float]],
    folder: Path,
    *,
    seeds: int = SEEDS,
    jobs: Workers = -1,
    progress: Progress | None = None,
) -> list[list[list[Solution]]]:
    """Solutions by experiment at one noise, row and seed; ``folder`` keeps each run."""
    tasks = [
        Task(_work, (e.table, e.key, index, noise, seed), _definition(e, row, noise, seed))
        for e, noise in cases
        for index, row in enumerate(e.rows)
        for seed in range(seeds)
    ]
    results = iter(run_all(tasks, folder, jobs, progress))
    return [
        [[solution_of(next(results)) for _ in range(seeds)] for _ in experiment.rows]
        for experiment, _ in cases
    ]


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
