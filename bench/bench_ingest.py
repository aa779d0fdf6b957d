"""How fast 20 stations put results into one PostgreSQL, and how many bytes a result takes.

    python bench/bench_ingest.py [RESULTS=400] [WRITERS=20]

Results have 22 measurements, one capture, and texts that they share. Each writer is a process with
a connection of its own, to a server that this script starts, synced at each commit. The bytes are
those of all tables and indices, less those of an empty history. Nothing is judged: the times are
those of this machine, with the load that is printed.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from motorid.quality.history import MeasurementRecord, open_history
from tests.history.records import record
from tests.history.servers import running

MEASURED = 22


def one(number: int, writer: int) -> object:
    """A result as a product of a plant has it."""
    measured = tuple(
        MeasurementRecord(f"Q{k}", "N·m/A", 1.0 + number / 1e6, 1e-3, 0.9, 1.1, 2e-3, "PASS")
        for k in range(MEASURED)
    )
    return replace(record(number, station=f"line-{writer}"), measurements=measured)


def write(place: str, writer: int, count: int) -> None:
    """Adds so many results."""
    with open_history(place, create=False) as history:
        for number in range(writer * count, (writer + 1) * count):
            history.add(one(number, writer))  # type: ignore[arg-type]


def size(place: str) -> int:
    """Bytes of the database on its server."""
    with open_history(place, create=False) as history, history.reading() as connection:
        asked = connection.exec_driver_sql("SELECT pg_database_size(current_database())")
        return int(asked.scalar_one())


def main(arguments: list[str]) -> int:
    """Prints the figures."""
    count = int(arguments[0]) if arguments else 400
    writers = int(arguments[1]) if len(arguments) > 1 else 20
    each = max(1, count // writers)
    with running(settings="-c fsync=on") as server, ProcessPoolExecutor(writers) as pool:
        place = server.database("ingest")
        with open_history(place) as history:
            history.add(one(-1, 0))  # type: ignore[arg-type]
        empty = size(place)
        list(pool.map(os.getpgid, [0] * writers))  # they are there
        began = time.perf_counter()
        list(pool.map(write, [place] * writers, range(writers), [each] * writers))
        took = time.perf_counter() - began
        with open_history(place) as history:
            history_bytes = size(place) - empty
            found, problems = history.count() - 1, history.verify().problems
    with tempfile.TemporaryDirectory() as name:
        path = Path(name, "line.db")
        with open_history(path) as history:
            history.add(one(-1, 0))  # type: ignore[arg-type]
            before = path.stat().st_size
            write(str(path), 0, each * writers)
        file_bytes = path.stat().st_size - before
    print(f"{found} results by {writers} writers, {len(problems)} problems")
    print(f"load average           {os.getloadavg()[0]:8.1f}")
    print(f"results a second       {found / took:8.1f}")
    print(f"bytes a result, server {history_bytes / found:8.0f}")
    print(f"bytes a result, file   {file_bytes / found:8.0f}")
    return int(found != each * writers or bool(problems))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
