"""How long a line's questions take as commands, against the number of results in its history.

    python bench/bench_history.py [LARGEST=160000] [file|postgresql] [TURNS=3]

Results are those of line_history.py: 22 measurements each, 20 stations, ten million a year. A
quarter of LARGEST, half and all of it are asked the same, each by a command in a process of its
own, the quickest of TURNS. The law is a straight line through the three: seconds for a million
more results, 0 where an index answers; the column after it is that line at ten million. Both are
of the processor's time, which a busy machine changes less: of the command and, behind the plus, of
the server's processes. Ends with 1 where a command misses its target at LARGEST and the cores were
free.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from bench import line_history
from bench.plant import year
from motorid.quality.history import History, months, open_history

YEAR = 10_000_000  # results
TURNS = 3
MOST_S, MOST_MB, MOST_OF_A_MONTH_S = 1.0, 200.0, 10.0
MOST_OF_A_YEAR_S = 600.0  # for limits that are changed
MONTH = timedelta(days=30)
SETTLED_S = 0.3
REJUDGE = "rejudge --stored --jobs 2"
TIGHTER = ("low = 2.4\nhigh = 2.8", "low = 2.45\nhigh = 2.75")  # of R_25
COMMAND = """
import re, sys, time
from pathlib import Path
from motorid.cli.main import run
code = run(sys.argv[1:])
most = re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text()).group(1)
sys.exit(f"{code} {time.process_time()} {int(most) / 1024}")
"""  # a parent's wait would give its own size for a child's


class Taken(NamedTuple):
    """By a command, and by the server for it."""

    wall_s: float
    cpu_s: float
    server_s: float
    memory_mb: float

    @property
    def both_s(self) -> float:
        """As if one after the other."""
        return self.cpu_s + self.server_s


def questions(where: str, history: History, tighter: str) -> dict[str, list[str]]:
    """Of the newest month, of a motor in the middle, and of ``tighter`` limits."""
    (newest,) = history.results(last=1)
    serial = f"D{int(newest.serial[1:]) // 2:08d}"
    since = f"{newest.at - MONTH:%Y-%m-%dT%H:%M}"
    trend = ["trend", where, "--quantity", "K_25", "--product", "sim-disc"]
    return {
        "list --serial": ["history", "list", where, "--serial", serial],
        "list --outcome FAIL": ["history", "list", where, "--outcome", "FAIL"],
        "list": ["history", "list", where],
        "trend --last 100": [*trend, "--last", "100"],
        "trend of a month": [*trend, "--since", since],
        REJUDGE: ["history", "rejudge", where, "--product", tighter, "--stored", "--jobs", "2"],
    }


def ask(words: list[str], turns: int, server: int | None) -> Taken:
    """The least time of some turns."""
    found = []
    for _ in range(turns):
        before, began = ended_s(server), time.perf_counter()
        call = [sys.executable, "-c", COMMAND, *words]
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        wall_s = time.perf_counter() - began
        code, cpu_s, memory_mb = done.stderr.splitlines()[-1].split()
        assert code in ("0", "1"), done.stderr
        server_s = ended_s(server) - before
        found.append(Taken(wall_s, float(cpu_s), server_s, float(memory_mb)))
    return min(found)


def ended_s(server: int | None) -> float:
    """Processor seconds of the children of ``server`` that have ended: one for each connection."""
    if server is None:
        return 0.0
    time.sleep(SETTLED_S)  # a connection that was closed ends a moment later
    words = Path(f"/proc/{server}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, words[13:15])) / os.sysconf("SC_CLK_TCK")


@contextlib.contextmanager
def place(kind: str) -> Iterator[tuple[str, int | None]]:
    """A file, or a server of our own and its process."""
    if kind == "postgresql":
        from tests.history.servers import running

        with running(settings="-c max_wal_size=8GB -c shared_buffers=1GB") as server:
            pid = (server.folder / "data" / "postmaster.pid").read_text().split()[0]
            yield server.database("year"), int(pid)
    else:
        with tempfile.TemporaryDirectory() as folder:
            yield str(Path(folder, "line.db")), None


def grow(history: History, first: int, last: int, block: int) -> None:
    """Adds the results from ``first`` to ``last``, in whole blocks."""
    if months.divided(history.engine):
        if first == 0:
            year.stage(history)
        year.repeat(history, first, last)
        year.analyse(history)
        return
    if first == 0:
        line_history.fill(history, block)
    line_history.repeat(history, block, last // block, first=max(1, first // block))


def main(arguments: list[str]) -> int:
    """One row a question and size."""
    largest = int(arguments[0]) if arguments else 160_000
    kind = arguments[1] if len(arguments) > 1 else "file"
    most = int(arguments[2]) if len(arguments) > 2 else TURNS
    block = year.BLOCK if kind == "postgresql" else min(year.BLOCK, largest // 4)
    sizes = [size // block * block for size in (largest // 4, largest // 2, largest)]
    taken: dict[str, list[Taken]] = {}
    with (
        tempfile.TemporaryDirectory() as folder,
        place(kind) as (where, server),
        open_history(where) as history,
    ):
        tighter = Path(folder, "tighter.toml")
        tighter.write_text(line_history.PRODUCT.text.replace(*TIGHTER))
        for before, size in zip([0, *sizes], sizes, strict=False):
            began = time.perf_counter()
            grow(history, before, size, block)
            print(f"{size} results in {time.perf_counter() - began:.0f} s", flush=True)
            for name, words in questions(where, history, str(tighter)).items():
                turns = 1 if name == REJUDGE else most
                taken.setdefault(name, []).append(ask(words, turns, server))
    load = os.getloadavg()[0]
    print(f"{kind}, load average {load:.1f}; seconds (processor), MB")
    print(f"| command | {' | '.join(map(str, sizes))} | for a million more | at {YEAR:,} |")
    print("|---" * (len(sizes) + 3) + "|")
    late = []
    for name, found in taken.items():
        slope, start = np.polyfit(sizes, [one.both_s for one in found], 1)
        law, a_year_s = 1e6 * slope, start + slope * YEAR
        cells = (
            f"{t.wall_s:.2f} ({t.cpu_s:.2f} + {t.server_s:.2f}), {t.memory_mb:.0f}" for t in found
        )
        print(f"| {name} | {' | '.join(cells)} | {law:.2f} | {a_year_s:.1f} |")
        late += [name] if missed(name, found[-1], a_year_s) else []
    if load > 0.5 * (os.cpu_count() or 1):
        print("other programs hold the cores: times are shown and not judged")
        return 0
    print(f"missed: {', '.join(late) or 'none'}")
    return min(1, len(late))


def missed(name: str, found: Taken, a_year_s: float) -> bool:
    """Whether it took more than it may."""
    if "month" in name:
        return found.wall_s > MOST_OF_A_MONTH_S
    if name == REJUDGE:
        return a_year_s > MOST_OF_A_YEAR_S
    return found.wall_s > MOST_S or found.memory_mb > MOST_MB


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
