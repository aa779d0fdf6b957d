"""Files that appear whole or not at all, and never over another one unasked."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path

from motorid.errors import DataError, UsageError

TRIAL_BYTES = 4096
USUAL = 0o666  # what open() asks for


def write_whole(path: Path, data: bytes, *, force: bool = False, mode: int = USUAL) -> None:
    """Writes ``data`` to ``path`` through a synced sibling: whole, or not at all.

    ``mode``: who may read and write it, as far as the system's mask allows that.
    Raises UsageError when ``path`` exists (unless ``force``), DataError when the disk refuses.
    """
    refuse_existing(path, force)
    sibling = _sibling(path)
    try:
        with open(sibling, "wb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        _place(sibling, path, force)
        sync_folder(path.parent)
    except FileExistsError:
        raise _exists(path) from None
    except OSError as error:
        raise DataError(
            f"{path} cannot be written ({error.strerror or error}): nothing was put there"
        ) from None
    finally:
        with contextlib.suppress(OSError):  # it is gone already after a rename
            sibling.unlink()


def refuse_existing(path: Path, force: bool) -> None:
    """Raises UsageError when ``path`` exists and may not be replaced, or has no folder."""
    if path.is_dir():
        raise UsageError(f"{path} is a folder: name a file in it")
    if not force and os.path.lexists(path):  # a link that leads nowhere is in the way too
        raise _exists(path)
    if path.exists() and not path.is_file():
        raise UsageError(f"{path} is no ordinary file: name another")
    if not path.parent.is_dir():
        raise UsageError(f"the folder {path.parent} does not exist: make it, or write elsewhere")


def check_writable(path: Path, *, force: bool = False) -> None:
    """Tries, before long work, whether ``write_whole`` can put a file there.

    Raises UsageError as ``refuse_existing``, DataError when the disk or the folder refuses.
    """
    refuse_existing(path, force)
    sibling = _sibling(path)
    try:
        with open(sibling, "wb") as file:
            file.write(bytes(TRIAL_BYTES))
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise DataError(f"{path} cannot be written ({error.strerror or error})") from None
    finally:
        with contextlib.suppress(OSError):  # it could not be made
            sibling.unlink()


def _sibling(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def sync_folder(folder: Path) -> None:
    """Makes a new name in ``folder`` last through a power failure, where the system can."""
    if sys.platform == "win32":
        return  # it syncs names itself, and opens no folders
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _place(sibling: Path, path: Path, force: bool) -> None:
    """Gives the sibling its name in one step; FileExistsError where another got there first."""
    if force:
        os.replace(sibling, path)
        return
    try:
        os.link(sibling, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if os.path.lexists(path):
            raise FileExistsError(str(path)) from None
        os.rename(sibling, path)


def _exists(path: Path) -> UsageError:
    return UsageError(f"{path} exists already: name another file, or --force to replace it")
