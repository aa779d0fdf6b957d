"""Opens what a person named: a file with a beginning and an end, or one sentence why not.

A pipe without a writer would be waited on for ever, a device would never end, and a name may be
none that a file can have: each is refused before anything is read.
"""

from __future__ import annotations

import os
import stat
from io import BufferedReader
from pathlib import Path

from motorid.errors import MotoridError
from motorid.visible import on_one_line

FOLDER = "{} is a folder: name a file in it"
KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def file_size(path: Path, error: type[MotoridError]) -> int:
    """Bytes in the regular file ``path``, which is not opened. Raises ``error``, naming it."""
    name = on_one_line(str(path))
    try:
        found = os.stat(path)
    except (OSError, ValueError) as problem:  # a NUL in the name
        said = getattr(problem, "strerror", None) or problem
        raise error(f"{name}: cannot be read: {said}") from None
    _refuse_other_kinds(name, found.st_mode, error)
    return found.st_size


def open_file(path: Path, error: type[MotoridError]) -> BufferedReader:
    """The regular file ``path``, to be read. Raises ``error``, naming it, where it is none."""
    name = on_one_line(str(path))
    try:
        file = open(path, "rb", opener=_without_waiting)  # noqa: SIM115 - the caller closes it
        try:
            _refuse_other_kinds(name, os.fstat(file.fileno()).st_mode, error)
        except MotoridError:
            file.close()
            raise
        return file
    except IsADirectoryError:
        raise error(FOLDER.format(name)) from None
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
            f"{on_one_line(str(path))}: larger than {what} may be ({size(most)}): is it one?"
        )
    return data


def size(count: int) -> str:
    """A number of bytes as a person reads it."""
    for unit, many in (("GiB", 1 << 30), ("MiB", 1 << 20), ("KiB", 1 << 10)):
        if count >= many:
            return f"{count / many:.4g} {unit}"
    return f"{count} B"


def _refuse_other_kinds(name: str, mode: int, error: type[MotoridError]) -> None:
    if stat.S_ISDIR(mode):
        raise error(FOLDER.format(name))
    if not stat.S_ISREG(mode):
        kind = next((said for is_kind, said in KINDS if is_kind(mode)), "no regular file")
        raise error(f"{name} is {kind}: name a file")


def _without_waiting(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))
