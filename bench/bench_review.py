"""The default estimator against the best method of every table of the review, at 1 % noise.

python bench/bench_review.py [--seeds 100] [--tables 2 3 7] [--folder DIR]

RMS error over the seeds, parameter by parameter, in units of the best method's, and evaluations in
units of the smallest population's. Experiments whose data do not tell the parameters are left out:
one step under a quadratic load or of two masses, and Table 6 with noise. Ends with 1 when a goal is
missed. Finished runs are kept in the folder; give a new one after the estimator has changed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from motorid.workflow.compare_tables import Block, compare_table

WORST_RATIO = 1.03
SHARE_OF_EVALUATIONS = 1 / 50
NOT_TOLD = {"4-step", "5-step", "6-both", "6-speed"}


def judged(block: Block) -> bool:
    """Prints one experiment's lines; true where the goals are met."""
    default, *others = block.lines
    fewest = min((line.row.budget for line in others if line.row.n), default=0)
    share = default.summary.evaluations / fewest if fewest else 0.0
    good = default.summary.failed == 0 and share <= SHARE_OF_EVALUATIONS
    print(f"{block.experiment.key}: {default.summary.evaluations:.0f} evaluations, "
          f"{100 * share:.1f} % of the smallest population's")  # fmt: skip
    for name, rms in default.summary.rms.items():
        rivals = {x.row.label: x.summary.rms[name] for x in others if name in x.summary.rms}
        best = min(rivals, key=rivals.__getitem__)
        ratio = rms / rivals[best]
        good &= ratio <= WORST_RATIO
        print(f"  {name:<4}{rms:9.4f} %   {ratio:6.3f} x the best ({best})")
    return good


def main() -> int:
    """Print every table's lines."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--tables", type=int, nargs="*", default=[2, 3, 4, 5, 7, 8, 9])
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--jobs", type=int, default=-1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        good = True
        for number in options.tables:
            result = compare_table(number, folder, seeds=options.seeds, jobs=options.jobs)
            for block in result.blocks:
                if block.noise > 0 and block.experiment.key not in NOT_TOLD:
                    good &= judged(block)
    print("goals met" if good else f"MISSED: {WORST_RATIO} x, 1/50 of the evaluations")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
