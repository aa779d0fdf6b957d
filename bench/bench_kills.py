"""Random kills of a station and outages of its history: is the history equal to the disk?

    python bench/bench_kills.py [EVENTS=100] [FIRST=0] [FOLDER]

A station inspects motors in a process of its own and adds its verdicts to a history. At a drawn
moment it is killed (SIGKILL). Meanwhile its history is as ever, locked by another program, or not
where it was. Then the next shift begins. In the end each verdict on disk must be in the history
once, as it was shown; its chain of seals must hold, with every mark that an inspection keeps; and
each order that was accepted must be judged, or named as not judged. Ends with 1 where not.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from motorid.quality.history import open_history
from motorid.workflow.shift_history import MARK, anchors

COMMAND = [sys.executable, "-m", "motorid.cli.main", "station", "--product", "sim-disc", "--rig",
           "sim-line", "--speed", "max", "--listen", "0", "--queue", "9"]  # fmt: skip
AS_EVER, LOCKED, GONE = KINDS = "as ever", "locked", "gone"
ORDERS = 4  # at most, of a shift
LONGEST_S = 3.0  # from a shift's first order to its event, and of an outage
PATIENCE_S = 120.0  # for what must come in the end
OLD_S = 60.0  # a journal that nobody writes to any more


class Shift:
    """A station's process and one connection to it."""

    def __init__(self, folder: Path, book: Path) -> None:
        call = [*COMMAND, "-o", str(folder), "--history", str(book), "--station", "line-1"]
        self.process = subprocess.Popen(
            call,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stderr is not None
        port = int(self.process.stderr.readline().rsplit(":", 1)[1])
        self.link = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.rest = b""

    def order(self, **order: Any) -> None:
        self.link.sendall(json.dumps(order).encode() + b"\n")

    def heard(self, until: float) -> Iterator[dict[str, Any]]:
        """Every answer that comes before then (``time.monotonic``)."""
        while (left := until - time.monotonic()) > 0.0:
            if select.select([self.link], [], [], left)[0]:
                *lines, self.rest = (self.rest + self.link.recv(65536)).split(b"\n")
                yield from map(json.loads, lines)

    def kill(self) -> None:
        self.process.send_signal(signal.SIGKILL)
        self.process.communicate()
        self.link.close()


@contextlib.contextmanager
def without(book: Path, kind: str) -> Iterator[None]:
    """The history locked by another program, or not where it was."""
    if kind == AS_EVER or not book.exists():
        yield
    elif kind == LOCKED:
        with contextlib.closing(sqlite3.connect(book, timeout=PATIENCE_S)) as other:
            other.execute("BEGIN EXCLUSIVE")
            yield
            other.rollback()
    else:
        away = book.with_name("away")
        away.mkdir()
        found = [one for one in book.parent.glob("line.db*") if one != away]
        for one in found:
            one.rename(away / one.name)
        book.mkdir()
        try:
            yield
        finally:
            book.rmdir()
            for one in found:
                (away / one.name).rename(one)
            away.rmdir()


def shift(folder: Path, book: Path, first: int, rng: np.random.Generator) -> tuple[str, set[str]]:
    """One shift with its event; the kind of that, and the orders that were accepted."""
    kind = str(rng.choice(KINDS))
    station, accepted = Shift(folder, book), set()
    serials = [f"D{first + n:06d}" for n in range(1 + int(rng.integers(ORDERS)))]
    for serial in serials:
        station.order(order="inspect", serial=serial)
    until = time.monotonic() + rng.uniform(0.0, LONGEST_S)
    with without(book, kind):
        for said in station.heard(until):
            accepted |= {said["serial"]} if said["event"] == "accepted" else set()
    station.kill()
    for journal in folder.rglob("*.journal"):
        os.utime(journal, (time.time() - OLD_S, time.time() - OLD_S))
    return kind, accepted


def left_over(folder: Path, book: Path) -> set[str]:
    """A last shift adds what is missing; what it says was ordered and never judged."""
    station = Shift(folder, book)
    until = time.monotonic() + PATIENCE_S
    while not all((one.parent / MARK).exists() for one in folder.rglob("verdict.json")):
        if time.monotonic() > until:
            break
        time.sleep(0.1)
    station.order(order="status")
    missing = set(next(station.heard(time.monotonic() + PATIENCE_S))["not_judged"])
    station.kill()
    return missing


def faults(folder: Path, book: Path, accepted: set[str], named: set[str]) -> list[str]:
    """What is not as it should be."""
    stored = [json.loads(one.read_text(encoding="utf-8")) for one in folder.rglob("verdict.json")]
    times = [datetime.fromisoformat(v["time"]) for v in stored]
    disk = Counter((v["serial"], v["outcome"], at) for v, at in zip(stored, times, strict=True))
    with open_history(book) as history:
        rows = Counter((r.serial, r.outcome, r.at) for r in history.results())
        checked = history.verify(list(anchors(folder)))
    out = [f"on disk and not in the history: {one}" for one in disk - rows]
    out += [f"in the history and not on disk: {one}" for one in rows - disk]
    out += [str(one) for one in checked.problems]
    lost = accepted - {v["serial"] for v in stored} - named
    print(f"{sum(disk.values())} verdicts on disk, {sum(rows.values())} in the history")
    return out + [f"accepted, and neither judged nor named: {one}" for one in sorted(lost)]


def main(events: int, first: int, folder: Path) -> int:
    """The number of faults, at most 1."""
    shifts, book = folder / "shift", folder / "line.db"
    shifts.mkdir()
    kinds: Counter[str] = Counter()
    accepted: set[str] = set()
    for event in range(first, first + events):
        kind, more = shift(shifts, book, 10 * event, np.random.default_rng([2028, event]))
        kinds[kind] += 1
        accepted |= more
    found = faults(shifts, book, accepted, left_over(shifts, book))
    said = ", ".join(f"{kind} ({count} times)" for kind, count in sorted(kinds.items()))
    print(f"{events} shifts, each ended by a kill; its history was meanwhile {said}")
    print(f"{len(accepted)} orders accepted; {len(found)} faults")
    print("\n".join(found))
    return min(len(found), 1)


if __name__ == "__main__":
    counts = [int(word) for word in sys.argv[1:3]]
    with contextlib.ExitStack() as stack:
        where = sys.argv[3] if len(sys.argv) > 3 else stack.enter_context(
            tempfile.TemporaryDirectory())  # fmt: skip
        sys.exit(main(*([*counts, *(100, 0)[len(counts) :]]), Path(where)))
