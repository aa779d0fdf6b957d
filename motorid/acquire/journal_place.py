"""Where an open journal goes on when its name, or the folder of it, is removed in mid-run."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from tempfile import gettempdir
from typing import BinaryIO

from motorid.acquire import lock
from motorid.capture.whole import sync_folder

KEPT = "kept"  # what a journal's name ends with where its own is taken
MOST_NAMES = 100


def create(path: Path) -> BinaryIO:
    """A new file to write, and to copy from should its name vanish. Raises FileExistsError."""
    return open(path, "x+b")


def is_named(file: BinaryIO, path: Path) -> bool:
    """Whether ``path`` still leads to the open ``file``; True where the system does not say."""
    try:
        found = os.stat(path)
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError:
        return True
    return os.path.samestat(found, os.fstat(file.fileno()))


def copy_elsewhere(file: BinaryIO, path: Path) -> tuple[BinaryIO, Path]:
    """A copy of the open ``file`` under the first name that takes it, synced and locked.

    ``path`` is absolute: the folder that the process is in may be the one that is gone. ``file``
    ends up closed. Raises OSError, and leaves it open, where no folder takes a copy.
    """
    file.flush()
    refusal = OSError("its name was removed, and no folder takes a copy")
    for place in _names(path):
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            copy = create(place)
        except OSError as error:
            refusal = error
            continue
        try:
            lock.hold(copy)
            file.seek(0)
            shutil.copyfileobj(file, copy)
            copy.flush()
            os.fsync(copy.fileno())
            sync_folder(place.parent)
        except OSError as error:  # no room there
            refusal = error
            with contextlib.suppress(OSError):
                copy.close()
            place.unlink(missing_ok=True)
            continue
        file.close()
        return copy, place
    file.seek(0, os.SEEK_END)
    raise refusal


def _names(path: Path) -> Iterator[Path]:
    """Its own name in its own folder, made again if need be; else another name or folder."""
    folders = [path.parent, Path(os.path.expanduser("~")), Path(gettempdir())]
    for folder in filter(Path.is_absolute, folders):  # a home that is not known stays "~"
        yield folder / path.name
        for number in count(1):
            if number > MOST_NAMES:
                break
            yield folder / (f"{path.name}.{KEPT}" + (f"-{number}" if number > 1 else ""))
