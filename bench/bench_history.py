"""How long the questions of a line take, against the number of results in its history.

    python bench/bench_history.py [LARGEST=320000]        (2000000 takes some 5 minutes)

Results are made without captures, four quantities each, two in a hundred FAIL, from 20 stations; a
quarter of LARGEST, half and all of it are asked the same. The law is the exponent p of
time ~ results**p from the smallest to the largest: 0 where an index answers, 1 where all are read.
Nothing is judged: the times are those of this machine.
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from sqlalchemy import insert

from motorid.quality.history import History, Query, open_history
from motorid.quality.history import schema as s

BEGAN = datetime(2026, 1, 5, 6, 0, tzinfo=UTC)
PIECE = 10_000  # results in a transaction
TURNS = 5  # the least time of so many
QUANTITIES = ("R", "K", "B", "J")


def result(number: int) -> dict[str, Any]:
    """A row of the results."""
    return {
        "id": number, "key": f"{number:064d}", "kind": "check", "serial": f"SN-{number:08d}",
        "product": "pump-motor", "outcome": "FAIL" if number % 50 == 0 else "PASS",
        "marginal": False, "at": BEGAN + timedelta(seconds=3 * number),
        "station": f"line-{number % 20}", "operator": "", "note": "", "versions": {},
    }  # fmt: skip


def measured(number: int, name: str) -> dict[str, Any]:
    """A row of its measurements."""
    return {
        "result": number, "name": name, "unit": "1", "value": 1.0 + number % 50 / 1e3,
        "uncertainty": 0.01, "low": 0.9, "high": 1.1, "guard_band": 0.0, "outcome": "PASS",
        "marginal": False, "reason": "",
    }  # fmt: skip


def fill(history: History, first: int, last: int) -> None:
    """Adds the results from ``first`` to ``last``."""
    for begin in range(first, last + 1, PIECE):
        numbers = range(begin, min(begin + PIECE, last + 1))
        with history.engine.begin() as connection:
            connection.execute(insert(s.results), [result(n) for n in numbers])
            rows = [measured(n, name) for n in numbers for name in QUANTITIES]
            connection.execute(insert(s.measurements), rows)


def questions(history: History, count: int) -> dict[str, Callable[[], Any]]:
    """What ``motorid history list`` and ``motorid trend`` ask."""
    serial, failed = Query(serial=f"SN-{count // 2:08d}"), Query(outcome="FAIL")
    return {
        "list --serial": lambda: (history.results(serial, last=50), history.count(serial)),
        "list --outcome FAIL": lambda: (history.results(failed, last=50), history.count(failed)),
        "list": lambda: (history.results(last=50), history.count()),
        "trend --last 100": lambda: history.series("R", last=100),
    }


def least(ask: Callable[[], Any]) -> float:
    """Seconds."""
    found = []
    for _ in range(TURNS):
        began = time.perf_counter()
        ask()
        found.append(time.perf_counter() - began)
    return min(found)


def main() -> None:
    """One row a question."""
    largest = int(sys.argv[1]) if len(sys.argv) > 1 else 320_000
    sizes = (largest // 4, largest // 2, largest)
    times: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as folder, open_history(Path(folder) / "line.db") as history:
        there = 0
        for size in sizes:
            fill(history, there + 1, size)
            there = size
            for name, ask in questions(history, size).items():
                times.setdefault(name, []).append(least(ask))
    print(f"| question | {' | '.join(f'{size} results, ms' for size in sizes)} | p |")
    print("|---" * (len(sizes) + 2) + "|")
    for name, taken in times.items():
        law = math.log(taken[-1] / taken[0]) / math.log(sizes[-1] / sizes[0])
        print(f"| {name} | {' | '.join(f'{1e3 * one:.1f}' for one in taken)} | {law:.2f} |")


if __name__ == "__main__":
    main()
