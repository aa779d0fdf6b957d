"""Whether the files of runs can be written, asked before a motor moves."""

from __future__ import annotations

import math
import os
import shutil
from collections.abc import Sequence
from pathlib import Path

from motorid.acquire.journal import journal_path
from motorid.capture import store
from motorid.capture.naming import refuse_other_format
from motorid.capture.whole import check_writable
from motorid.errors import DataError, UsageError
from motorid.program import Program
from motorid.rig import Rig

WIRE_BYTES, STORED_BYTES = 2, 8  # of a reading, at most
MORE_BYTES = 3  # of a sample, in a journal: heads and check sums
TICK_BYTES = 8


def check_outputs(paths: Sequence[Path], rig: Rig, program: Program, *, force: bool) -> None:
    """Raises UsageError where a name is taken or is no capture's, DataError where a file cannot be.

    Every run has its capture there at the end, and one of them its journal meanwhile.
    """
    for path in paths:
        refuse_other_format(path)
        check_writable(path, force=force)
        if not force and os.path.lexists(journal := journal_path(path)):
            raise UsageError(in_the_way(journal))
        store.refuse_long(path, _planned_samples(rig, program))
    captures, journal_bytes = planned_bytes(rig, program)
    needed = {path.parent: 0.0 for path in paths}
    for path in paths:
        needed[path.parent] += captures
    for folder, size in needed.items():
        _check_room(folder, size + journal_bytes)


def in_the_way(journal: Path) -> str:
    """A journal that lies where another is to be written."""
    return (
        f"{journal} exists: another capture is writing it, or one was cut short; "
        f"`motorid recover {journal}` keeps what it holds, --force moves it aside"
    )


def planned_bytes(rig: Rig, program: Program) -> tuple[float, float]:
    """What a capture and its journal will take, at most; 0 where the board sets the rate."""
    samples = _planned_samples(rig, program)
    readings = len(rig.sampling.channels)
    capture = samples * (TICK_BYTES + STORED_BYTES * readings)
    return capture, samples * (MORE_BYTES + WIRE_BYTES * readings)


def _planned_samples(rig: Rig, program: Program) -> float:
    samples = program.duration_s * rig.sampling.rate_hz
    return samples if math.isfinite(samples) else 0.0


def _check_room(folder: Path, needed: float) -> None:
    try:
        free = shutil.disk_usage(folder).free
    except OSError:  # a drive that does not say
        return
    if needed > free:
        raise DataError(
            f"{folder} has {free / 1e6:.0f} MB free, and these runs may take "
            f"{needed / 1e6:.0f} MB: make room, or write elsewhere"
        )
