"""The default estimator against the best method of every table of the review, at 1 % noise.

python bench/bench_review.py [--experiments 2 3 8-w100:400] [--folder DIR] [--jobs N] [--page FILE]

RMS error over the seeds, parameter by parameter, in units of the best method's, and evaluations in
units of the smallest population's. An experiment is run over 100 seeds, or over those after its
colon. Experiments whose data do not tell the parameters are left out: one step under a quadratic
load or of two masses, and Table 6 with noise. Ends with 1 when a goal is missed. Finished runs are
kept in the folder; give a new one after the estimator has changed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.search.problem import Solution
from motorid.search.review import tables
from motorid.search.review.experiment import Experiment
from motorid.search.review.ideal import Ideal
from motorid.search.review.run import figures_found, relative_to_nominal
from motorid.workflow.compare_tables import run_cases

NOISE = 0.01
WORST_RATIO = 1.03
SHARE_OF_EVALUATIONS = 1 / 50
EXPERIMENTS = ("2", "3", "4-staircase", "5-prbs", "7", "8-w100", "8-w1", "9-w100", "9-w1")
SEEDS = 100
RESAMPLES = 1000
INTERVAL = (0.05, 0.95)

INTRODUCTION = """# The default estimator beside the best method of each table

Written by `python bench/bench_review.py --page docs/review-best.md`; do not edit it. The
experiments are those of [review.md](review.md), at 1 % noise.

The column *rms* is the default's error over the seeds, in percent of the nominal value. The column
*× the best* is its ratio to the smallest rms error of all other rows; the goal is at most 1.03.
A table has up to forty rows, and their errors scatter with the seeds. So the smallest of many is
small by chance too. The other columns show how much:

- *90 %* is the interval of that ratio to that one row, by bootstrap over the seeds, the same
  seeds for both.
- *apart* is the ratio where one half of the seeds chooses the best row and the other half judges it
  (median over splits).
- *× the ideal* compares with a limit: maximum likelihood that is given the noise, to first order
  about the truth, on the same records. Near 1, the default extracts all the information of these
  records. A row that is better on them is better by chance.
- *searches × the ideal* is the same ratio for the minimum of the table's own cost in the long run.
  Above 1, this cost does not weigh the channels by their noise.
"""
HEAD = "| | rms, % | × the best | 90 % | apart | × the ideal | searches × the ideal |"

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ratio:
    """rms of the default in units of the best row's: as seen, its interval, without the luck."""

    rms: float  # %
    best: str
    seen: float
    low: float
    high: float
    apart: float
    ideal: float  # rms in units of the ideal's on the same records
    searches: float  # of the table's own cost, in units of the ideal's, in the long run


@dataclass(frozen=True)
class Verdict:
    """One experiment: evaluations of the default, and what part of the smallest population's."""

    experiment: Experiment
    seeds: int
    evaluations: float
    share: float
    ratios: dict[str, Ratio]
    good: bool


def judge(experiment: Experiment, by_row: Sequence[Sequence[Solution]]) -> Verdict:
    """Of the runs by row and seed, the default's row first."""
    fewest = min((row.budget for row in experiment.rows if row.n), default=0)
    evaluations = float(np.mean([run.evaluations for run in by_row[0]]))
    share = evaluations / fewest if fewest else 0.0
    labels = np.array([row.label for row in experiment.rows])
    found = [figures_found(experiment, runs) for runs in by_row]
    ideal = Ideal.of(experiment, NOISE)
    errors = ideal.errors(len(by_row[0]))
    ratios = {}
    for index, (name, truth) in enumerate(experiment.truth.items()):
        misses = np.array([relative_to_nominal(f[name], np.array(truth)) for f in found])
        told = ~np.isnan(misses).all(axis=1)
        best, rms, seen, low, high, apart = _ratio(misses[told] ** 2)
        against = rms / float(np.sqrt(np.mean(errors[index] ** 2)))
        label, searches = str(labels[told][1 + best]), float(ideal.searches()[index])
        ratios[name] = Ratio(rms, label, seen, low, high, apart, against, searches)
    good = (
        all(run.values for run in by_row[0])
        and share <= SHARE_OF_EVALUATIONS
        and max(ratio.seen for ratio in ratios.values()) <= WORST_RATIO
    )
    return Verdict(experiment, len(by_row[0]), evaluations, share, ratios, good)


def _ratio(squares: Floats) -> tuple[int, float, float, float, float, float]:
    """Best rival, rms, ratio, its interval, ratio apart: of squared errors (rows, seeds)."""
    rms = _rms(squares)
    best = int(np.argmin(rms[1:]))
    rng = np.random.default_rng(1)
    seeds = squares.shape[1]
    again = [_rms(squares[:, rng.integers(seeds, size=seeds)]) for _ in range(RESAMPLES)]
    low, high = np.quantile([r[0] / r[1 + best] for r in again], INTERVAL)
    orders = [rng.permutation(seeds) for _ in range(RESAMPLES)]
    apart = np.median([_apart(squares[:, order]) for order in orders])
    seen = rms[0] / rms[1 + best]
    return best, float(rms[0]), float(seen), float(low), float(high), float(apart)


def _rms(squares: Floats) -> Floats:
    return np.asarray(np.sqrt(np.nanmean(squares, axis=1)))


def _apart(squares: Floats) -> float:
    """Each half of the seeds chooses the best row, and the other half judges it."""
    half = squares.shape[1] // 2
    first, second = squares[:, :half], squares[:, half : 2 * half]
    rivals = [
        judges[1 + int(np.argmin(_rms(chooses)[1:]))]
        for chooses, judges in ((first, second), (second, first))
    ]
    return float(np.sqrt(np.nanmean(squares[0, : 2 * half]) / np.nanmean(np.concatenate(rivals))))


def markdown(verdict: Verdict) -> str:
    """One experiment's section."""
    lines = [
        f"## {verdict.experiment.key}, {verdict.seeds} seeds",
        "",
        f"{verdict.evaluations:.0f} evaluations"
        + (
            f", {100 * verdict.share:.1f} % of the smallest population's." if verdict.share else "."
        ),
        "",
        HEAD,
        "|" + "---|" * (HEAD.count("|") - 1),
    ]
    for name, r in verdict.ratios.items():
        lines.append(
            f"| {name} | {r.rms:.4f} | {r.seen:.3f} ({r.best}) | {r.low:.3f} to {r.high:.3f} | "
            f"{r.apart:.3f} | {r.ideal:.3f} | {r.searches:.3f} |"
        )
    lines += [
        f"\n{name}: the ideal itself is {r.seen / r.ideal:.3f} × that row on these records."
        for name, r in verdict.ratios.items()
        if r.seen > WORST_RATIO
    ]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Print every experiment's lines."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--experiments", nargs="*", default=EXPERIMENTS, metavar="KEY[:SEEDS]")
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--jobs", type=int, default=-1)
    parser.add_argument("--page", type=Path)
    options = parser.parse_args()
    every = {e.key: e for number in tables.TABLES for e in tables.table(number)}
    verdicts = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        for asked in options.experiments:
            key, _, seeds = asked.partition(":")
            if key not in EXPERIMENTS:
                parser.error(f"no experiment {key}: choose from {', '.join(EXPERIMENTS)}")
            case, count = (every[key], NOISE), int(seeds or SEEDS)
            (by_row,) = run_cases([case], folder, seeds=count, jobs=options.jobs)
            verdicts.append(judge(every[key], by_row))
            print(markdown(verdicts[-1]), flush=True)
    if options.page:
        sections = "\n".join(markdown(verdict) for verdict in verdicts)
        options.page.write_text(f"{INTRODUCTION}\n{sections}", encoding="utf-8")
    missed = [f"{v.experiment.key} over {v.seeds} seeds" for v in verdicts if not v.good]
    goals = f"{WORST_RATIO} x, 1/50 of the evaluations"
    print(f"MISSED ({goals}): {', '.join(missed)}" if missed else f"goals met ({goals})")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
