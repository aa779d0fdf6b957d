"""Whether another processor gives another answer: each kernel of the linear algebra that runs here.

python bench/bench_kernels.py                            100 drawn rigs and the frozen cases
python bench/bench_kernels.py --rigs 3 --cases sim       fewer

Fits the frozen cases of tests/frozen and drawn rigs of the coverage study in child processes, each
under one of OpenBLAS's kernels, and compares with the processor's own. Ends with 1 where a
parameter moves by more than .01 of its standard uncertainty, or a status changes. One thread; the
results go into bench/results/kernels.json with the commit that made them.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.coverage.rigs import draw_bench
from bench.coverage.runs import record, save
from bench.kernels.child import RIG, fitted
from bench.kernels.choice import KNOWN, others, probed
from bench.kernels.moved import MOST_U, Moved, moved
from motorid.errors import MotoridError
from tests.frozen.cases import CASES
from tests.frozen.compare import table

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results" / "kernels.json"
NAMES = [case.name for case in CASES]


def main() -> int:
    """Prints a table; 1 where a kernel gives another answer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=100, help="drawn rigs")
    parser.add_argument("--first", type=int, default=0, help="seed of the first rig")
    parser.add_argument("--cases", nargs="*", default=NAMES, choices=NAMES, metavar="CASE")
    parser.add_argument("--kernels", nargs="*", metavar="KERNEL", help="of those that run here")
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args()
    made_by, own = commit(), probed("")
    rest = others(own, chosen.kernels or KNOWN) if own else []
    absent = set(chosen.kernels or ()) - {own, *rest}
    if absent:
        parser.error(f"the kernel {', '.join(sorted(absent))} does not run here")
    if own is None or not rest:
        parser.error("fewer than two kernels run here: there is nothing to compare")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        seeds = range(chosen.first, chosen.first + chosen.rigs)
        subjects = [*chosen.cases, *(rig for seed in seeds for rig in captured(seed, folder))]
        first = fitted(subjects, folder, own)
        found = [moved(kernel, first, fitted(subjects, folder, kernel)) for kernel in rest]
    say(own, len(subjects), found)
    store(chosen.out, made_by, own, subjects, found)
    return 1 if any(one.bad for one in found) else 0


def captured(seed: int, folder: Path) -> list[str]:
    """The name of a drawn rig whose captures are now in ``folder``; none where it refuses."""
    try:
        save(record(draw_bench(seed), folder), folder, seed)
    except MotoridError:
        return []
    return [f"{RIG}{seed}"]


def say(own: str, subjects: int, found: Sequence[Moved]) -> None:
    """The table, and the worst differences."""
    print(f"{subjects} subjects, against {own}; held: {MOST_U} u\n")
    print("| kernel | subjects beyond | differences | greatest / u | of |\n|---|---|---|---|---|")
    for one in found:
        row = summary(one)
        print(f"| {one.kernel} | {len(row['subjects'])} | {row['differences']} "
              f"| {row['greatest_u']:.1e} | {row['of']} |")  # fmt: skip
    for one in found:
        if one.bad:
            print(f"\n{one.kernel}\n\n{table(one.bad)}")


def summary(one: Moved) -> dict[str, Any]:
    """Of one kernel, for the results file."""
    greatest = one.greatest
    return {
        "subjects": sorted({d.case for d in one.bad}),
        "differences": len(one.bad),
        "greatest_u": float(f"{greatest.size:.2e}") if greatest else 0.0,
        "of": f"{greatest.case}: {greatest.path}" if greatest else "",
    }


def store(
    path: Path, made_by: str, own: str, subjects: Sequence[str], found: Sequence[Moved]
) -> None:
    """The results file."""
    import numpy
    import scipy

    results = {
        "commit": made_by,
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "kernel": own,
        "held_u": MOST_U,
        "subjects": len(subjects),
        "kernels": {one.kernel: summary(one) for one in found},
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


def commit() -> str:
    """What is checked out, with a plus where files differ from it."""
    done = subprocess.run(
        ["git", "-C", str(ROOT), "describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
