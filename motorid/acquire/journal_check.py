"""Whether a journal is whole: damage told from a run that was cut short.

A run that is cut short leaves a last record with too few bytes. A record that has all its bytes
and fails its check, or that another good one follows, was damaged. The last record of a closed
journal holds the SHA-256 of all before it.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from motorid.acquire.journal import CLOSED, CRC, HEAD, LONGEST_RECORD, MAGIC, Kind
from motorid.errors import DataError
from motorid.limits import JOURNAL, refuse_large

KINDS = frozenset(kind.value[0] for kind in Kind)
LATEST_NS = 10**18  # of a port's clock, which starts with the computer: thirty years
_SMALLEST = HEAD.size + CRC.size


class Wholeness(Enum):
    """What is known of a journal."""

    SOUND = "sound"  # closed, and as it was then
    OPEN = "open"  # every record is good; it was never closed
    CUT = "cut"  # its end is missing
    DAMAGED = "damaged"


@dataclass(frozen=True)
class JournalState:
    """``at``: the byte where the damage or the missing end begins."""

    whole: Wholeness
    at: int = 0
    why: str = ""


def check_journal(path: Path) -> JournalState:
    """The state of the journal in ``path``. Raises DataError where it cannot be read at all."""
    refuse_large(path, JOURNAL)
    try:
        return state_of(path.read_bytes())
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from None


def state_of(data: bytes) -> JournalState:
    """The state of a journal's bytes."""
    if not data.startswith(MAGIC):
        if MAGIC.startswith(data):
            return JournalState(Wholeness.CUT, len(data), "it ends in its first line")
        return JournalState(Wholeness.DAMAGED, 0, "its first line")
    at, last, last_data = len(MAGIC), 0, b""
    while at < len(data):
        size = _good(data, at)
        if not size:
            return _broken(data, at)
        last, last_data, at = at, data[at + HEAD.size : at + size - CRC.size], at + size
    return _end(data, last, last_data)


def _end(data: bytes, last: int, last_data: bytes) -> JournalState:
    """Of a journal whose records are all good; the last one begins at ``last``."""
    if not last:
        return JournalState(Wholeness.CUT, len(data), "it ends before its header")
    try:
        closed = json.loads(last_data)[CLOSED] if data[last] == Kind.MARK.value[0] else None
    except (ValueError, KeyError, TypeError, RecursionError):
        closed = None
    if closed is None:
        return JournalState(Wholeness.OPEN, len(data))
    if closed == {"bytes": last, "sha256": hashlib.sha256(data[:last]).hexdigest()}:
        return JournalState(Wholeness.SOUND, len(data))
    return JournalState(Wholeness.DAMAGED, last, "it does not hold what it held when it was closed")


def _good(data: bytes, at: int) -> int:
    """Size of the good record that begins at ``at``; 0 where none does."""
    if len(data) - at < _SMALLEST or data[at] not in KINDS:
        return 0
    _, nanoseconds, length = HEAD.unpack_from(data, at)
    end = at + HEAD.size + length
    if nanoseconds > LATEST_NS or length > LONGEST_RECORD or end + CRC.size > len(data):
        return 0
    good = CRC.pack(zlib.crc32(memoryview(data)[at:end])) == data[end : end + CRC.size]
    return _SMALLEST + length if good else 0


def _broken(data: bytes, at: int) -> JournalState:
    """Of a journal whose first bad record begins at ``at``."""
    rest = len(data) - at
    if not any(memoryview(data)[at:]):  # a file system gave it room and no bytes
        return JournalState(Wholeness.CUT, at, "zeros in place of its end")
    whole = rest >= _SMALLEST and HEAD.unpack_from(data, at)[2] + _SMALLEST <= rest
    if whole or _other_length(data, at) or _another(data, at + 1):
        return JournalState(Wholeness.DAMAGED, at, "a record fails its check")
    return JournalState(Wholeness.CUT, at, f"{rest} bytes of a record")


def _other_length(data: bytes, at: int) -> bool:
    """Whether the record at ``at`` is the last one and only its length is wrong."""
    rest = len(data) - at
    if rest < _SMALLEST:
        return False
    kind, nanoseconds, _ = HEAD.unpack_from(data, at)
    head = HEAD.pack(kind, nanoseconds, rest - _SMALLEST)
    body = memoryview(data)[at + HEAD.size : len(data) - CRC.size]
    return CRC.pack(zlib.crc32(body, zlib.crc32(head))) == data[-CRC.size :]


def _another(data: bytes, start: int) -> bool:
    """Whether a good record begins at or after ``start``; checks no more than the file's bytes."""
    left = 4 * len(data)
    for at in range(start, len(data) - _SMALLEST + 1):
        if data[at] in KINDS:
            length = HEAD.unpack_from(data, at)[2]
            if length <= len(data) - at - _SMALLEST and length <= left:
                left -= length
                if _good(data, at):
                    return True
    return False
