"""Whether another process, or another capture of this one, is at work on a file."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from motorid.errors import DataError
from motorid.reading import open_file


def is_free(path: Path) -> bool | None:
    """Whether no capture writes the journal in ``path``; None where the system cannot tell."""
    with open_file(path, DataError) as file:
        return hold(file)


def hold(file: BinaryIO) -> bool | None:
    """Keeps a file until it is closed, or its process is gone; False where another one has it."""
    try:
        import fcntl

        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):  # Windows, and some network drives
        return None
    return True
