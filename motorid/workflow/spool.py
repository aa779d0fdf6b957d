"""What goes into an object store is on this computer first, synced, and stays until it is there.

A store that cannot be reached stops no motor: what was measured waits in the spool. MOTORID_SPOOL
names its folder.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from motorid.errors import DataError, UsageError
from motorid.storage import object_store, user_folders
from motorid.storage.place import File, Url

FOLDER = "MOTORID_SPOOL"


def first(target: File) -> Path:
    """Where ``target`` is written first: itself, or for a URL a path in the spool. DataError."""
    if isinstance(target, Path):
        return target
    path = _folder() / target.scheme / target.key
    user_folders.made(path.parent, FOLDER)
    return path


def _folder() -> Path:
    named = os.environ.get(FOLDER)
    return Path(named) if named else user_folders.state("spool")


def refuse_existing(target: Url, *, force: bool) -> None:
    """Raises UsageError where the store holds that name already; a silent store is no reason."""
    with contextlib.suppress(DataError):
        if not force and object_store.exists(target):
            raise UsageError(f"{target} exists already: name another, or --force to replace it")


def deliver(path: Path, target: Url, *, force: bool = False) -> Url:
    """Moves a file from the spool into the store, read back and compared.

    Raises DataError, and keeps the file, where the store does not take it.
    """
    try:
        object_store.put(path, target, force=force)
    except DataError as error:
        raise DataError(f"{error}; the capture is safe in {path}: copy it there later") from None
    path.unlink()
    return target
