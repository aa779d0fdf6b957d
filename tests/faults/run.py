"""Runs random fault schedules: ``python -m tests.faults.run --count 1000 [--first 1]``.

A schedule that breaks a law is printed, and comes again with ``--first SEED --count 1``.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.faults.laws import run
from tests.faults.schedule import draw


def main() -> int:
    """Runs them; the exit code is 1 when any broke a law."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--first", type=int, default=1)
    options = parser.parse_args()
    began = time.monotonic()
    totals: Counter[str] = Counter()
    for seed in range(options.first, options.first + options.count):
        with tempfile.TemporaryDirectory() as folder:
            try:
                outcome = run(draw(seed), Path(folder))
            except Exception as error:
                print(f"ERROR {error!r} in {draw(seed)}", flush=True)
                totals["errors"] += 1
                continue
        totals["schedules"] += 1
        totals["broken"] += bool(outcome.broken)
        totals[f"exit {outcome.exit_code}"] += 1
        totals["with samples"] += outcome.kept > 0
        totals["samples sent"] += outcome.sent
        totals["samples read"] += outcome.read
        totals["samples kept"] += outcome.kept
        if outcome.broken:
            print(f"BROKEN {outcome.broken} in {draw(seed)}; said: {outcome.says}", flush=True)
    print(f"{dict(sorted(totals.items()))} in {time.monotonic() - began:.0f} s")
    return 1 if totals["broken"] or totals["errors"] else 0


if __name__ == "__main__":
    sys.exit(main())
