"""The default estimator against the best method of every table of the review, at 1 % noise.

python bench/bench_review.py [--seeds 100] [--experiments 2 3 8-w100] [--folder DIR] [--jobs N]

RMS error over the seeds, parameter by parameter, in units of the best method's, and evaluations in
units of the smallest population's. Experiments whose data do not tell the parameters are left out:
one step under a quadratic load or of two masses, and Table 6 with noise. Ends with 1 when a goal is
missed. Finished runs are kept in the folder; give a new one after the estimator has changed.

The goal compares with the smallest of up to forty rms errors that all scatter with the seeds, and
the smallest of many is small by luck too. So two more figures stand beside each ratio: the 90 %
interval of the ratio to that one row (bootstrap over the seeds, the same seeds for both), and the
ratio where half of the seeds choose the best row and the other half judge it (median over splits).
The first says what the ratio is worth, the second what is left of it without the luck. Last stands
the rms error in units of the Cramer-Rao bound, below which no unbiased method stays for long; with
n seeds it scatters by 1/sqrt(2 n) of itself.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.review import tables
from motorid.estimate.review.experiment import Experiment
from motorid.estimate.review.run import figures_found, relative_to_nominal
from motorid.estimate.search.problem import Solution
from motorid.workflow.compare_tables import run_cases

NOISE = 0.01
WORST_RATIO = 1.03
SHARE_OF_EVALUATIONS = 1 / 50
EXPERIMENTS = ("2", "3", "4-staircase", "5-prbs", "7", "8-w100", "8-w1", "9-w100", "9-w1")
RESAMPLES = 1000
INTERVAL = (0.05, 0.95)
DERIVATIVE_STEP = 1e-5  # relative, on either side of the truth

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Ratio:
    """rms of the default in units of the best row's: as seen, its interval, without the luck."""

    rms: float  # %
    best: int  # which rival
    seen: float
    low: float
    high: float
    chosen_apart: float

    @classmethod
    def of(cls, squares: Floats) -> Ratio:
        """Of squared errors, (rows, seeds), the default first; NaN where a run gave no answer."""
        rms = _rms(squares)
        best = int(np.argmin(rms[1:]))
        rng = np.random.default_rng(1)
        seeds = squares.shape[1]
        again = [_rms(squares[:, rng.integers(seeds, size=seeds)]) for _ in range(RESAMPLES)]
        low, high = np.quantile([r[0] / r[1 + best] for r in again], INTERVAL)
        orders = [rng.permutation(seeds) for _ in range(RESAMPLES)]
        apart = float(np.median([_chosen_apart(squares[:, order]) for order in orders]))
        seen = float(rms[0] / rms[1 + best])
        return cls(float(rms[0]), best, seen, float(low), float(high), apart)


def _rms(squares: Floats) -> Floats:
    return np.asarray(np.sqrt(np.nanmean(squares, axis=1)))


def _chosen_apart(squares: Floats) -> float:
    """Each half of the seeds chooses the best row, and the other half judges it."""
    half = squares.shape[1] // 2
    halves = squares[:, :half], squares[:, half : 2 * half]
    rivals = [
        judge[1 + int(np.argmin(_rms(choose)[1:]))]
        for choose, judge in (halves, halves[::-1])
    ]  # fmt: skip
    return float(np.sqrt(np.nanmean(squares[0, : 2 * half]) / np.nanmean(np.concatenate(rivals))))


def bounds(experiment: Experiment) -> dict[str, float]:
    """Cramer-Rao bounds of the parameters from the record and its noise, percent of nominal."""
    model, record = experiment.truth_model or experiment.model, experiment.clean()
    truth = np.array(list(experiment.truth.values()))
    steps = DERIVATIVE_STEP * np.eye(len(truth))
    outputs = model.outputs(truth * np.concatenate([1.0 + steps, 1.0 - steps]), record)
    slopes = (outputs[: len(truth)] - outputs[len(truth) :]) / (2.0 * DERIVATIVE_STEP)
    deviations = [
        NOISE * experiment.noise_share.get(name, 1.0) * np.abs(record.measured[name]).max()
        for name in experiment.channels
    ]
    scaled = (slopes / np.array(deviations)[:, None]).reshape(len(truth), -1)
    deviation = np.sqrt(np.diag(np.linalg.inv(scaled @ scaled.T)))
    return dict(zip(experiment.truth, (100.0 * deviation).tolist(), strict=True))


def judged(experiment: Experiment, by_row: list[list[Solution]]) -> bool:
    """Prints one experiment's lines; true where the goals are met."""
    fewest = min((row.budget for row in experiment.rows if row.n), default=0)
    evaluations = float(np.mean([run.evaluations for run in by_row[0]]))
    share = evaluations / fewest if fewest else 0.0
    good = all(run.values for run in by_row[0]) and share <= SHARE_OF_EVALUATIONS
    print(f"{experiment.key}: {len(by_row[0])} seeds, {evaluations:.0f} evaluations, "
          f"{100 * share:.1f} % of the smallest population's")  # fmt: skip
    found, bound = [figures_found(experiment, runs) for runs in by_row], bounds(experiment)
    for name, truth in experiment.truth.items():
        misses = [relative_to_nominal(figures[name], np.array(truth)) for figures in found]
        told = [index for index, miss in enumerate(misses) if not np.isnan(miss).all()]
        ratio = Ratio.of(np.array([misses[index] for index in told]) ** 2)
        good &= ratio.seen <= WORST_RATIO
        label = experiment.rows[told[1 + ratio.best]].label
        print(f"  {name:<4}{ratio.rms:9.4f} %   {ratio.seen:6.3f} x the best ({label}); "
              f"90 % {ratio.low:.3f} to {ratio.high:.3f}; chosen apart {ratio.chosen_apart:.3f}; "
              f"{ratio.rms / bound[name]:.3f} x the bound",
              flush=True)  # fmt: skip
    return good


def main() -> int:
    """Print every experiment's lines."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--experiments", nargs="*", default=EXPERIMENTS, choices=EXPERIMENTS)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--jobs", type=int, default=-1)
    options = parser.parse_args()
    every = {e.key: e for number in tables.TABLES for e in tables.table(number)}
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        good = True
        for key in options.experiments:
            case = every[key], NOISE
            (by_row,) = run_cases([case], folder, seeds=options.seeds, jobs=options.jobs)
            good &= judged(every[key], by_row)
    print("goals met" if good else f"MISSED: {WORST_RATIO} x, 1/50 of the evaluations")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
