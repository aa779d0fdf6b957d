"""Tasks that workers of a cluster run: plain, deadly once, deadly always, slow to be allowed."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

PATIENCE_S = 60.0


def plain(number: int) -> dict[str, Any]:
    """Its number's root, to the last digit."""
    return {"root": number**0.5}


def deadly(number: int, mark: Path | None = None) -> dict[str, Any]:
    """Kills its worker; with a mark only where that is not there yet."""
    if mark is None or not mark.exists():
        if mark is not None:
            mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return plain(number)


def gated(number: int, gate: Path) -> dict[str, Any]:
    """Waits until its gate is there, and a little longer: meanwhile its scheduler may go."""
    until = time.monotonic() + PATIENCE_S
    while not gate.exists() and time.monotonic() < until:
        time.sleep(0.01)
    time.sleep(0.2)
    return plain(number)


def broken(number: int) -> dict[str, Any]:
    """A defect of the task itself."""
    raise ZeroDivisionError(number)


def surroundings(number: int) -> dict[str, Any]:
    """What Dask has made of the worker that computes this, and which process it is."""
    import dask

    names = ("OPENBLAS_NUM_THREADS", "MALLOC_TRIM_THRESHOLD_")
    profiled = dask.config.get("distributed.worker.profile.enabled")
    found = {"n": number, "process": os.getpid(), "profiled": profiled}
    return found | {one: os.environ.get(one) for one in names}
