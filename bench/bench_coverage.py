"""Whether the stated uncertainty holds: simulated rigs with everything on, fitted as they come.

python bench/bench_coverage.py --rigs 2000 --out coverage.jsonl   go on where the file ends
python bench/bench_coverage.py --tables coverage.jsonl --causes   the tables of what is there
python bench/bench_coverage.py --effects --parts bound fit auto   motors with iron or windage
python bench/bench_coverage.py --cluster local:4   on a Dask cluster; workers start in this folder

Every rig is drawn by its own seed, so a study can be stopped, resumed and repeated rig by rig. One
JSON line a rig. See docs/coverage.md.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one rig a core
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.coverage import tables
from bench.coverage.rigs import NEUTRAL
from bench.coverage.score import How, score
from motorid.workflow.task import Result, Task
from motorid.workflow.tasks import Workers, answers

Row = dict[str, Any]
PARTS = ("bound", "fit", "naive", "auto")


def stored(path: Path) -> list[Row]:
    """The records of a study so far; a line torn by an interruption is left out."""
    rows = []
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                rows.append(json.loads(line))
            except json.JSONDecodeError:
                print(f"{path}: an unfinished line is left out", file=sys.stderr)
    return rows


def scored(seeds: list[int], jobs: Workers, how: How) -> Iterator[Row]:
    """The records of these rigs, as they finish."""
    tasks = {seed: Task(one, (seed, how), {"rig": seed}) for seed in seeds}
    for _, found in answers(tasks, jobs):
        yield json.loads(found["row"])


def one(seed: int, how: How) -> Result:
    """A rig's record as text, which keeps what is not finite."""
    how.folder.mkdir(parents=True, exist_ok=True)  # also where a worker has another disk
    return {"row": json.dumps(score(seed, how=how))}


def study(path: Path, seeds: Iterable[int], jobs: Workers, how: How) -> None:
    """Adds the records that ``path`` still lacks."""
    done = {row["seed"] for row in stored(path)}
    todo = [seed for seed in seeds if seed not in done]
    with path.open("a", encoding="utf-8") as file:
        for row in scored(todo, jobs, how):
            file.write(json.dumps(row) + "\n")
            file.flush()


def merged(paths: Sequence[Path]) -> list[Row]:
    """The records of several files, rig by rig: later files add to and replace earlier ones."""
    rows: dict[int, Row] = {}
    for path in paths:
        for row in stored(path):
            rows[row["seed"]] = rows.get(row["seed"], {}) | row
    return list(rows.values())


def main() -> int:
    """Runs or sums up a study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first rig")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--cluster", help="a Dask cluster in place of --jobs, as of motorid fit")
    parser.add_argument("--out", type=Path, default=Path("coverage.jsonl"))
    parser.add_argument("--captures", type=Path, help="folder in which captures stay")
    parser.add_argument(
        "--parts", nargs="*", default=PARTS[:3], choices=PARTS, help="of a record: what to make"
    )
    parser.add_argument(
        "--without", action="append", default=[], choices=tuple(NEUTRAL), help="take an effect out"
    )
    parser.add_argument(
        "--effects", action="store_true", help="one to three of iron, windage and load friction"
    )
    parser.add_argument(
        "--tables", type=Path, nargs="+", help="sum up these files together instead of running"
    )
    parser.add_argument("--causes", action="store_true", help="what drives the misses")
    args = parser.parse_args()
    if args.tables is None:
        seeds = range(args.first, args.first + args.rigs)
        with tempfile.TemporaryDirectory() as passing:
            folder = args.captures or Path(passing)
            folder.mkdir(parents=True, exist_ok=True)
            keep = args.captures is not None
            how = How(folder, tuple(args.parts), tuple(args.without), args.effects, keep)
            study(args.out, seeds, args.cluster or args.jobs, how)
    rows = merged(args.tables or [args.out])
    print(tables.summary(rows))
    if args.causes:
        print("\n" + tables.cause_tables(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
