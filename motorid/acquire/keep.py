"""From a journal to a capture file that was read back; only then does the journal go."""

from __future__ import annotations

import contextlib
import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motorid.acquire.assemble import UNUSABLE, NoPlaceError, NoSamplesError, assemble
from motorid.acquire.journal import journal_path, open_journal
from motorid.acquire.journal_check import Wholeness, check_journal
from motorid.acquire.leftover import is_journal, refuse_growing, set_aside, target_of
from motorid.capture import store
from motorid.capture.model import NOTES, Capture
from motorid.capture.whole import refuse_existing
from motorid.errors import DataError, MotoridError

RAW, EMPTY, TORN = "raw", "empty", "torn"  # what a journal is called that stays
BAD = "bad"  # and a capture that is not what was written


@dataclass(frozen=True)
class Kept:
    """What became of a journal: samples in the capture, and whether it holds more than these."""

    samples: int
    unplaced: bool = False
    torn: bool = False


def keep(journal: Path, target: Path, *, force: bool = False) -> Kept:
    """Builds the capture of ``journal`` in ``target``, and reads it back.

    The journal stays. Raises NoSamplesError where there is nothing to keep, NoPlaceError where
    nothing has a place in a run, DataError where the file cannot be made or reads back otherwise.
    """
    with open_journal(journal) as contents:
        run = assemble(contents)
        torn = contents.torn > 0
    try:
        store.save(run, target, force)
        _read_back(run, target)
    except MotoridError as error:
        raise type(error)(f"{error}; the run is in {journal}: {_advice(journal, target)}") from None
    except UNUSABLE as error:
        raise DataError(
            f"this run makes no capture file ({error}): it is in {journal}, as it came"
        ) from None
    return Kept(len(run), "unplaced_samples" in run.provenance["link"], torn)


def _advice(journal: Path, target: Path) -> str:
    if journal == journal_path(target):
        return "`motorid recover` builds the capture"
    return f"`motorid recover {journal}` builds the capture"


def _read_back(run: Capture, path: Path) -> None:
    """Raises DataError where a file does not say what was written; it is set aside then."""
    try:
        found = store.load(path)
        if len(found) == len(run) and digest(found) == digest(run):
            return
        problem = f"{path} reads back otherwise than it was written"
    except MotoridError as error:
        problem = str(error)
    bad = path.with_name(f"{path.name}.{BAD}")
    with contextlib.suppress(OSError):  # it is gone
        os.replace(path, bad)
        problem += f"; what is there is {bad.name} now"
    raise DataError(f"{problem}: the disk or its driver may be at fault")


def digest(capture: Capture) -> str:
    """SHA-256 of a capture's ticks and raw readings, whatever file they are in."""
    found = hashlib.sha256(np.asarray(capture.ticks, dtype="<i8").tobytes())
    for name, channel in capture.channels.items():
        raw = np.asarray(channel.raw)
        found.update(f"{name} {raw.dtype.str} {len(raw)};".encode())
        found.update(raw.tobytes())
    return found.hexdigest()


def recover(path: Path) -> Path:
    """Builds the capture that a journal holds, beside it; returns the capture's path.

    ``path`` is the journal, perhaps set aside, or the capture that it was meant for. Raises
    DataError when no sample of it makes a run: the journal is set aside then, so that its name is
    free, as ``raw`` where it holds anything. Raises UsageError when the capture exists or the
    journal is still being written.
    """
    journal = path if is_journal(path) else journal_path(path)
    target = target_of(journal)
    refuse_existing(target, force=False)
    refuse_growing(journal)
    try:
        kept = keep(journal, target)
    except NoSamplesError as error:
        aside = set_aside(journal, EMPTY)
        raise NoSamplesError(f"{journal}: {error}; it is {aside.name} now") from None
    except NoPlaceError as error:
        aside = set_aside(journal, RAW)
        raise NoPlaceError(f"{journal}: {error}; they are kept as they came in {aside}") from None
    if kept.unplaced:  # what a person may still read out of it
        set_aside(journal, RAW)
    elif kept.torn or check_journal(journal).whole is Wholeness.DAMAGED:
        set_aside(journal, TORN)
    else:
        journal.unlink()
    return target


def remarks(capture: Capture) -> list[str]:
    """What a person should know of a capture: what it lacks, and which of its sensors failed."""
    return [said for said in (missing(capture), *capture.provenance.get(NOTES, ())) if said]


def missing(capture: Capture) -> str:
    """What a capture lacks of its run, in a sentence; empty when nothing."""
    parts = []
    if capture.end_reason != "completed":
        parts.append(f"the run ended early ({capture.end_reason})")
        if capture.program is not None and len(capture) > 1:
            parts.append(f"{capture.time_s[-1]:.3f} of {capture.program.duration_s:.3f} s are here")
    lost = sum(gap.samples for gap in capture.gaps)
    if lost:
        plural = "s" if len(capture.gaps) > 1 else ""
        parts.append(f"{lost} samples are missing in {len(capture.gaps)} gap{plural}")
    return "; ".join(parts)
