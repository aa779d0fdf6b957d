"""Results by reference: new motors on the captures that are there, by many writers at once."""

from __future__ import annotations

import resource
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path

from motorid import json_seal
from motorid.capture import store
from motorid.quality.history import open_history
from motorid.quality.history.records import ResultRecord, from_stored
from motorid.quality.product import load_product
from motorid.workflow.check import CAPTURE, VERDICT


@dataclass(frozen=True)
class Written:
    """What one writer did; memory in MB after a tenth, and in the end."""

    count: int
    early_mb: float
    late_mb: float


def replay(
    url: str, folders: Sequence[Path], count: int, writers: int
) -> tuple[float, list[Written]]:
    """Seconds, and what each writer did."""
    share = count // writers
    began = time.monotonic()
    with ProcessPoolExecutor(writers) as pool:
        jobs = [
            pool.submit(write, url, folders[n % len(folders)], n, share) for n in range(writers)
        ]
        done = [job.result() for job in jobs]
    return time.monotonic() - began, done


def write(url: str, folder: Path, writer: int, count: int) -> Written:
    """``count`` motors of one station, each with a serial number of its own."""
    record, early, added = _record(folder), 0.0, 0
    with open_history(url) as history:
        for number in range(count):
            later = record.at + timedelta(seconds=number)
            serial = f"R{writer:02d}{number:06d}"
            added += history.add(
                replace(record, serial=serial, at=later, station=f"replay-{writer}")
            )
            if number == count // 10:
                early = _memory_mb()
    return Written(added, early, _memory_mb())


def _record(folder: Path) -> ResultRecord:
    stored = json_seal.read(folder / VERDICT, "a verdict")
    return from_stored(stored, [store.load(folder / CAPTURE)], limits=load_product("sim-disc").text)


def _memory_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
