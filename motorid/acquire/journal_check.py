"""Whether a journal is whole: damage told from a run that was cut short.

A run that is cut short leaves a last record with too few bytes. A record that has all its bytes
and fails its check, or that another good one follows, was damaged. The last record of a closed
journal holds the SHA-256 of all before it.
"""

from __future__ import annotations

import hashlib
import mmap
import zlib
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from motorid import json_text
from motorid.acquire.journal import CLOSED, CRC, HEAD, LONGEST_RECORD, MAGIC, Kind
from motorid.errors import DataError
from motorid.limits import JOURNAL, refuse_large
from motorid.reading import open_file

KINDS = frozenset(kind.value[0] for kind in Kind)
LATEST_NS = 10**18  # of a port's clock, which starts with the computer: thirty years
ZEROS = 16  # bytes; fewer may be data
Bytes = bytes | mmap.mmap
_SMALLEST = HEAD.size + CRC.size
_BLOCK = 1 << 20


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
        with open_file(path, DataError) as file:
            if not path.stat().st_size:
                return state_of(b"")
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                return state_of(data)
    except (OSError, ValueError) as error:
        what = getattr(error, "strerror", None) or error
        raise DataError(f"{path}: cannot be read: {what}") from None


def state_of(data: Bytes) -> JournalState:
    """The state of a journal's bytes."""
    first = data[: len(MAGIC)]
    if first != MAGIC:
        if MAGIC.startswith(first):
            return JournalState(Wholeness.CUT, len(data), "it ends in its first line")
        return JournalState(Wholeness.DAMAGED, 0, "its first line")
    at, last, last_data = len(MAGIC), 0, b""
    while at < len(data):
        size = _good(data, at)
        if not size:
            return _broken(data, at)
        last, last_data, at = at, data[at + HEAD.size : at + size - CRC.size], at + size
    return _end(data, last, last_data)


def _end(data: Bytes, last: int, last_data: bytes) -> JournalState:
    """Of a journal whose records are all good; the last one begins at ``last``."""
    if not last:
        return JournalState(Wholeness.CUT, len(data), "it ends before its header")
    try:
        closed = json_text.loads(last_data)[CLOSED] if data[last] == Kind.MARK.value[0] else None
    except (json_text.JsonError, KeyError, TypeError):
        closed = None
    if closed is None:
        return JournalState(Wholeness.OPEN, len(data))
    if closed == {"bytes": last, "sha256": _sha256(data, last)}:
        return JournalState(Wholeness.SOUND, len(data))
    return JournalState(Wholeness.DAMAGED, last, "it does not hold what it held when it was closed")


def _sha256(data: Bytes, size: int) -> str:
    made = hashlib.sha256()
    for begin in range(0, size, _BLOCK):
        made.update(data[begin : min(size, begin + _BLOCK)])
    return made.hexdigest()


def _good(data: Bytes, at: int) -> int:
    """Size of the good record that begins at ``at``; 0 where none does."""
    if len(data) - at < _SMALLEST or data[at] not in KINDS:
        return 0
    _, nanoseconds, length = HEAD.unpack_from(data, at)
    end = at + HEAD.size + length
    if nanoseconds > LATEST_NS or length > LONGEST_RECORD or end + CRC.size > len(data):
        return 0
    good = CRC.pack(zlib.crc32(data[at:end])) == data[end : end + CRC.size]
    return _SMALLEST + length if good else 0


def _broken(data: Bytes, at: int) -> JournalState:
    """Of a journal whose first bad record begins at ``at``."""
    rest = len(data) - at
    size = HEAD.unpack_from(data, at)[2] + _SMALLEST if rest >= _SMALLEST else rest + 1
    zeros = _zeros(data, at)
    if zeros == rest or (zeros >= ZEROS and rest - zeros < size):
        return JournalState(Wholeness.CUT, at, "zeros in place of its end")
    if size <= rest or _other_length(data, at) or _another(data, at + 1):
        return JournalState(Wholeness.DAMAGED, at, "a record fails its check")
    return JournalState(Wholeness.CUT, at, f"{rest} bytes of a record")


def _zeros(data: Bytes, at: int) -> int:
    """How many zeros end the bytes from ``at`` on: a file system gave room for what it lost."""
    end = len(data)
    while end > at:
        begin = max(at, end - _BLOCK)
        left = len(data[begin:end].rstrip(b"\0"))
        if left:
            return len(data) - begin - left
        end = begin
    return len(data) - at


def _other_length(data: Bytes, at: int) -> bool:
    """Whether the record at ``at`` is the last one and only its length is wrong."""
    rest = len(data) - at
    if rest < _SMALLEST:
        return False
    kind, nanoseconds, _ = HEAD.unpack_from(data, at)
    head = HEAD.pack(kind, nanoseconds, rest - _SMALLEST)
    body = data[at + HEAD.size : len(data) - CRC.size]
    return CRC.pack(zlib.crc32(body, zlib.crc32(head))) == data[len(data) - CRC.size : len(data)]


def _another(data: Bytes, start: int) -> bool:
    """Whether a good record begins within the longest record's bytes after ``start``."""
    left = 4 * LONGEST_RECORD
    end = min(len(data) - _SMALLEST, start + LONGEST_RECORD + _SMALLEST)
    for at in range(start, end + 1):
        if data[at] in KINDS:
            length = HEAD.unpack_from(data, at)[2]
            if length <= len(data) - at - _SMALLEST and length <= left:
                left -= length
                if _good(data, at):
                    return True
    return False
