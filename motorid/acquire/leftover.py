"""Journals that an earlier capture left behind: never deleted, never in the way for long."""

from __future__ import annotations

import os
import re
import time
from itertools import count
from pathlib import Path

from motorid.acquire.journal import SUFFIX, journal_path
from motorid.acquire.lock import is_free
from motorid.errors import DataError, UsageError

STILL_GROWING_S = 1.5  # a live journal is synced more often than this


_NAME = re.compile(
    rf"(?P<target>.+){re.escape(SUFFIX)}(?P<aside>\.(?:old|empty|torn|raw|kept)(?:-\d+)?)?",
    re.DOTALL,
)


def is_journal(path: Path) -> bool:
    """Whether a file is named as a journal is, perhaps set aside."""
    return _NAME.fullmatch(path.name) is not None


def target_of(journal: Path) -> Path:
    """Where its capture goes: run.h5.journal to run.h5, run.h5.journal.old to run.old.h5."""
    found = _NAME.fullmatch(journal.name)
    assert found is not None, journal
    target = journal.with_name(found["target"])
    return target.with_stem(target.stem + found["aside"]) if found["aside"] else target


def refuse_growing(journal: Path) -> None:
    """Raises UsageError when another capture still writes the journal."""
    try:
        free = is_free(journal)
        if free is None:
            free = not _grows(journal)
    except OSError as error:
        raise DataError(f"{journal}: cannot be read: {error.strerror or error}") from None
    if not free:
        raise UsageError(f"{journal} is still being written: let that capture finish")


def _grows(journal: Path) -> bool:
    """Where no lock tells."""
    before = journal.stat()
    if time.time() - before.st_mtime > STILL_GROWING_S:
        return False
    time.sleep(STILL_GROWING_S)
    return journal.stat().st_size != before.st_size


def set_aside(journal: Path, why: str) -> Path:
    """Gives a journal the first free name ``JOURNAL.WHY``, ``JOURNAL.WHY-2``, ...; returns it.

    One that is called so already keeps its name. Raises DataError where the folder does not let it.
    """
    found = _NAME.fullmatch(journal.name)
    if found is not None and found["aside"]:
        if re.fullmatch(rf"\.{why}(-\d+)?", found["aside"]):
            return journal
        name = journal.name.removesuffix(found["aside"])
    else:
        name = journal.name
    for number in count(1):
        aside = journal.with_name(f"{name}.{why}" + (f"-{number}" if number > 1 else ""))
        if not os.path.lexists(aside):
            break
    try:
        os.rename(journal, aside)
    except OSError as error:
        raise DataError(f"{journal} cannot be renamed: {error.strerror or error}") from None
    return aside


def make_way(target: Path) -> str:
    """Moves the journal aside that lies where a capture to ``target`` writes its own.

    Returns a sentence on it; "" where there is none. Raises UsageError while it still grows.
    """
    journal = journal_path(target)
    if not journal.exists():
        return ""
    refuse_growing(journal)
    aside = set_aside(journal, "old")
    return f"an earlier run left {journal}: it is {aside.name} now, for `motorid recover`"
