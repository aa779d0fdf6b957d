"""How long the line's page and its neighbours take on a history that is there.

    python bench/line_history.py line.db 190000 6
    python bench/bench_dashboard.py line.db ...

Each question is asked of each history; the table holds the least processor time and wall time of
three turns, in ms, and the exponent p of time ~ results**p from the smallest history to the
largest. ``VmHWM`` is the most memory that the process had. Nothing is judged.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import Any

from motorid.quality.history import History, Query, open_history
from motorid.quality.line import line

CHECKS = Query(kind="check")
TURNS = 3


def questions(history: History) -> dict[str, Callable[[], Any]]:
    """By name."""
    newest = history.results(last=1)[0]
    middle = history.result(newest.id // 2)
    assert middle is not None
    serial, failed = Query(serial=middle.serial), Query(outcome="FAIL")
    since = newest.at - timedelta(hours=10, minutes=7)
    return {
        "the line's page": lambda: line(history, CHECKS),
        "from within a day": lambda: line(history, replace(CHECKS, since=since)),
        "of a station": lambda: line(history, replace(CHECKS, station="line-04")),
        "of FAIL alone": lambda: line(history, replace(CHECKS, outcome="FAIL")),
        "of a motor": lambda: line(history, replace(CHECKS, serial=middle.serial)),
        "of no such station": lambda: line(history, replace(CHECKS, station="line-99")),
        "list --serial": lambda: (history.results(serial, last=50), history.count(serial)),
        "list --outcome FAIL": lambda: (history.results(failed, last=50), history.count(failed)),
        "trend --last 100": lambda: history.series("R_25", CHECKS, last=100),
    }


def least(ask: Callable[[], Any]) -> tuple[float, float]:
    """Processor time and wall time, s."""
    found = []
    for _ in range(TURNS):
        began, wall = time.process_time(), time.perf_counter()
        ask()
        found.append((time.process_time() - began, time.perf_counter() - wall))
    return min(found)


def main() -> None:
    """One row a question."""
    times: dict[str, list[tuple[float, float]]] = {}
    sizes = []
    for place in sys.argv[1:]:
        with open_history(place, create=False) as history:
            sizes.append(history.count())
            for name, ask in questions(history).items():
                times.setdefault(name, []).append(least(ask))
    print(f"| question | {' | '.join(f'{size} results: CPU, wall, ms' for size in sizes)} | p |")
    print("|---" * (len(sizes) + 2) + "|")
    for name, taken in times.items():
        law = math.log(taken[-1][0] / taken[0][0]) / math.log(max(sizes[-1] / sizes[0], 1.001))
        told = " | ".join(f"{1e3 * cpu:.1f}, {1e3 * wall:.1f}" for cpu, wall in taken)
        print(f"| {name} | {told} | {law:.2f} |")
    status = Path("/proc/self/status")
    if status.exists():
        print(next(one for one in status.read_text().splitlines() if one.startswith("VmHWM")))


if __name__ == "__main__":
    main()
