"""Every capture of the store fitted by a cluster whose workers are killed meanwhile."""

from __future__ import annotations

import csv
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import psutil

LOST = 3  # exit code of a cluster that was
PATIENCE_S = 1800.0
EVERY_S = 20.0  # between kills, in the mean
COMMAND = [sys.executable, "-m", "motorid.cli.main", "fit", "--model", "six"]


def refitted(captures: str, out: Path, count: int) -> Iterator[str]:
    """What is wrong: captures that are missing, failed or doubled in the table of fits."""
    rng, killed, began = np.random.default_rng(2030), 0, time.monotonic()
    call = [*COMMAND, "--cluster", "local:2", captures, "-o", str(out)]
    log = out.with_suffix(".log")
    code = LOST
    while code == LOST and time.monotonic() - began < PATIENCE_S:  # as it says: once more
        with log.open("w") as said:
            process = subprocess.Popen(call, stdout=said, stderr=said)
            while process.poll() is None:
                time.sleep(rng.exponential(EVERY_S))
                if workers := _workers(process.pid):
                    workers[int(rng.integers(len(workers)))].kill()
                    killed += 1
        code = process.returncode
    table = out / "fits.csv"
    if not table.exists():
        yield f"no fits: {log.read_text()[-500:]}"
        return
    with table.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    took = time.monotonic() - began
    print(f"{len(rows)} captures fitted out of the store in {took:.0f} s; {killed} workers killed")
    yield from (f"not fitted: {row['path']}: {row['failure']}" for row in rows if row["failure"])
    if len({row["path"] for row in rows}) != count or len(rows) != count:
        yield f"{len(rows)} fits of {count} captures"


def _workers(client: int) -> list[psutil.Process]:
    """The processes that compute for it."""
    try:
        children = psutil.Process(client).children()
        return [one for one in children if "spawn_main" in " ".join(one.cmdline())]
    except psutil.NoSuchProcess:
        return []
