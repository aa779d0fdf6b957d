"""Copies of what an object store gave, each under the SHA-256 of its bytes, on this computer.

MOTORID_CACHE names the folder, MOTORID_CACHE_MB how much it may hold; what was used least recently
goes first. A copy whose bytes are not those of its name any more is as good as none.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from pathlib import Path

from motorid.capture.whole import write_whole
from motorid.errors import DataError, UsageError
from motorid.reading import open_file
from motorid.storage import user_folders
from motorid.storage.user_folders import made

FOLDER, MOST = "MOTORID_CACHE", "MOTORID_CACHE_MB"
USUAL_MB = 2048
SUFFIX = ".h5"  # readers of captures look at it
EVERY = 200  # copies between looks at how much there is
_since = {"looked": EVERY}  # copies that this process has made


def folder() -> Path:
    """Where the copies are; made if need be. Raises DataError."""
    named = os.environ.get(FOLDER)
    return made(Path(named) if named else user_folders.cache("captures"), FOLDER)


def kept(sha256: str) -> Path | None:
    """The copy of that digest; None where there is none, or a damaged one."""
    path = folder() / f"{sha256}{SUFFIX}"
    try:
        with open_file(path, DataError) as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
    except (DataError, OSError):
        return None
    if found != sha256:
        return None
    with contextlib.suppress(OSError):  # of another user: it cannot be marked as used
        os.utime(path)
    return path


def keep(data: bytes) -> tuple[Path, str]:
    """A copy of ``data``, and its SHA-256. Raises DataError where the disk does not take it."""
    sha256 = hashlib.sha256(data).hexdigest()
    path = folder() / f"{sha256}{SUFFIX}"
    write_whole(path, data, force=True)
    _since["looked"] += 1
    if _since["looked"] > EVERY:
        _since["looked"] = 0
        make_room(path)
    return path, sha256


def make_room(newest: Path) -> None:
    """Deletes what was used least recently, until the rest fits; never ``newest``."""
    most = _most_bytes()
    found = []
    for path in folder().glob(f"*{SUFFIX}"):
        with contextlib.suppress(OSError):  # another process deleted it
            known = path.stat()
            found.append((known.st_mtime, known.st_size, path))
    total = sum(size for _, size, _ in found)
    for _, size, path in sorted(found):
        if total <= most or path == newest:
            break
        with contextlib.suppress(OSError):
            path.unlink()
        total -= size


def _most_bytes() -> int:
    said = os.environ.get(MOST) or str(USUAL_MB)
    if not said.isdecimal():
        raise UsageError(f"{MOST}={said!a} is no number of megabytes")
    return int(said) << 20
