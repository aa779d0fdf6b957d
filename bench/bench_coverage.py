"""Whether the stated uncertainty holds: simulated rigs with everything on, fitted as they come.

python bench/bench_coverage.py --rigs 2000 --out coverage.jsonl   go on where the file ends
python bench/bench_coverage.py --tables coverage.jsonl --causes   the tables of what is there

Every rig is drawn by its own seed, so a study can be stopped, resumed and repeated rig by rig. One
JSON line a rig. See docs/coverage.md.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one rig a core
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench.coverage import tables
from bench.coverage.rigs import NEUTRAL
from bench.coverage.score import score

Row = dict[str, Any]


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


def scored(seeds: list[int], jobs: int, how: Callable[..., Row]) -> Iterator[Row]:
    """The records of these rigs, in order."""
    with tempfile.TemporaryDirectory() as name:
        one = partial(how, folder=Path(name))
        if jobs == 1:
            yield from map(one, seeds)
            return
        with ProcessPoolExecutor(jobs) as pool:
            yield from pool.map(one, seeds)


def study(path: Path, seeds: Iterable[int], jobs: int, how: Callable[..., Row]) -> None:
    """Adds the records that ``path`` still lacks."""
    done = {row["seed"] for row in stored(path)}
    todo = [seed for seed in seeds if seed not in done]
    with path.open("a", encoding="utf-8") as file:
        for row in scored(todo, jobs, how):
            file.write(json.dumps(row) + "\n")
            file.flush()


def main() -> int:
    """Runs or sums up a study."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rigs", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="seed of the first rig")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("coverage.jsonl"))
    parser.add_argument("--no-naive", action="store_true", help="leave the other fit out")
    parser.add_argument(
        "--without", action="append", default=[], choices=tuple(NEUTRAL), help="take an effect out"
    )
    parser.add_argument("--tables", type=Path, help="sum up this file instead of running")
    parser.add_argument("--causes", action="store_true", help="what drives the misses")
    args = parser.parse_args()
    if args.tables is None:
        seeds = range(args.first, args.first + args.rigs)
        how = partial(score, with_naive=not args.no_naive, without=tuple(args.without))
        study(args.out, seeds, args.jobs, how)
    rows = stored(args.tables or args.out)
    print(tables.summary(rows))
    if args.causes:
        print("\n" + tables.cause_tables(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main())
