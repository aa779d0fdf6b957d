"""Opens what a person named: a file with a beginning and an end, or one sentence why not.

A pipe without a writer would be waited on for ever, a device would never end, and a name may be
none that a file can have: each is refused before anything is read.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import BinaryIO

from motorid.errors import MotoridError
from motorid.visible import on_one_line

KINDS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def open_file(path: Path, error: type[MotoridError]) -> BinaryIO:
    """The regular file ``path``, to be read. Raises ``error``, naming it, where it is none."""
    name = on_one_line(str(path))
    try:
        file = open(path, "rb", opener=_without_waiting)  # noqa: SIM115 - the caller closes it
        mode = os.fstat(file.fileno()).st_mode
        if stat.S_ISREG(mode):
            return file
        file.close()
        kind = next((said for is_kind, said in KINDS if is_kind(mode)), "no regular file")
        raise error(f"{name} is {kind}: name a file")
    except IsADirectoryError:
        raise error(f"{name} is a folder: name a file in it") from None
    except OSError as problem:
        raise error(f"{name}: cannot be read: {problem.strerror or problem}") from None
    except ValueError as problem:  # a NUL in the name
        raise error(f"{name}: cannot be read: {problem}") from None


def read_file(path: Path, error: type[MotoridError], most: int, what: str) -> bytes:
    """All of ``path``, which is to be ``what`` ("a rig file") of ``most`` bytes at the most.

    Raises ``error``, naming ``path``.
    """
    with open_file(path, error) as file:
        try:
            data = file.read(most + 1)
        except (OSError, MemoryError) as problem:
            said = getattr(problem, "strerror", None) or "this computer's memory does not hold it"
            raise error(f"{on_one_line(str(path))}: cannot be read: {said}") from None
    if len(data) > most:
        raise error(
            f"{on_one_line(str(path))}: larger than {what} may be ({_size(most)}): is it one?"
        )
    return data


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _size(size: int) -> str:
    return f"{size >> 20} MiB" if size < 1 << 30 else f"{size >> 30} GiB"
