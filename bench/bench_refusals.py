"""Captures that no motor gives, fitted: none of their parameters may be called estimated, unless
it is the one that the capture gives before it is spoilt (a sign that is put right; the resistance,
where the motion alone is another's).

python bench/bench_refusals.py --count 50 --seed 1     swapped, shuffled, foreign, reversed
python bench/bench_refusals.py --scaled                in a wrong unit: what a nameplate can show
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from functools import cache
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.spoilt import CASE_OF, SCALED, SPOILS, Spoilt, drawn
from motorid.errors import DataError
from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.identify import fit

MOST_EVALUATIONS = 20_000  # of one capture's model


def outcome(spoilt: Spoilt) -> tuple[str, Estimate | None, str]:
    """What became of one: a word, the estimate, what was said."""
    try:
        found = fit([spoilt.capture], model="six")
    except DataError as error:
        return "refused before", None, str(error)
    statuses = {p.status for p in found.parameters.values()}
    said = next((d.message for d in found.diagnostics if d.severity == "error"), "")
    known = [p for p in found.parameters.values() if p.status is Status.ESTIMATED]
    if known:
        usual = sound(spoilt.base)
        wrong = [p.name for p in known if not agree(p, usual.parameters[p.name])]
        return ("estimated" if wrong else "as before"), found, said or ", ".join(wrong)
    kinds = (Status.NOT_SUPPORTED, Status.DOUBTFUL, Status.NOT_IDENTIFIABLE)
    return next(str(s) for s in kinds if s in statuses), found, said


@cache
def sound(base: str) -> Estimate:
    """What a capture gives before it is spoilt."""
    return fit(list(CASE_OF[base].captures()[:1]), model="six")


def agree(one: Parameter, other: Parameter) -> bool:
    """Their intervals meet."""
    if one.interval_95 is None or other.interval_95 is None:
        return False
    low, high = zip(one.interval_95, other.interval_95, strict=True)
    return max(low) <= min(high)


def main() -> int:
    """1 where a parameter is estimated wrongly, or a fit had more than its share of evaluations."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scaled", action="store_true")
    args = parser.parse_args()
    counts: Counter[str] = Counter()
    most = 0
    for spoilt in drawn(args.seed, args.count, SCALED if args.scaled else SPOILS):
        begin = time.process_time()
        word, found, said = outcome(spoilt)
        seconds = time.process_time() - begin
        most = max(most, found.evaluations if found else 0)
        counts[word] += 1
        print(f"{spoilt.name:<48} {word:<16} {seconds:5.1f} s  {said[:90]}", flush=True)
    print(f"{dict(counts)}; at most {most} evaluations")
    return int(counts["estimated"] > 0 or most > MOST_EVALUATIONS)


if __name__ == "__main__":
    sys.exit(main())
