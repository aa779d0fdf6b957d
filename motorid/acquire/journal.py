"""The journal: every byte of a capture as it crossed the link, on disk before it is understood.

A file is ``MAGIC`` and then records: kind (one byte), host time in nanoseconds (u64), length (u32),
the data, and the CRC-32 of all that; little-endian. It only ever grows, so that a crash can spoil
nothing but its last record.
"""

from __future__ import annotations

import contextlib
import io
import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, BinaryIO

from motorid.errors import DataError

MAGIC = b"motorid journal 1\n"
SUFFIX = ".journal"
_HEAD = struct.Struct("<cQI")
_CRC = struct.Struct("<I")
_SMALLEST = _HEAD.size + _CRC.size


class Kind(Enum):
    """What a record holds."""

    HEADER = b"H"  # JSON: what was about to be captured
    RECEIVED = b"R"  # bytes from the board
    SENT = b"S"  # bytes to the board
    MARK = b"M"  # JSON: what the host was doing from here on


@dataclass(frozen=True)
class Record:
    """One entry. ``time_s`` is the port's clock."""

    kind: Kind
    time_s: float
    data: bytes

    @property
    def json(self) -> dict[str, Any]:
        """The object that a header or a mark holds. Raises DataError."""
        try:
            value = json.loads(self.data)
        except (ValueError, RecursionError):
            value = None
        if not isinstance(value, dict):
            raise DataError("a journal's header or mark is not a JSON object: it is damaged")
        return value


@dataclass(frozen=True)
class Journal:
    """A journal as read. ``torn`` counts the bytes after the last whole record."""

    header: Mapping[str, Any]
    records: tuple[Record, ...]  # without the header
    torn: int


def journal_path(target: Path) -> Path:
    """Where the journal of a capture file lives: beside it."""
    return target.with_name(target.name + SUFFIX)


def read_journal(path: Path) -> Journal:
    """The journal in ``path``, its torn tail left out. Raises DataError when it is none."""
    with open_journal(path) as reader:
        return Journal(reader.header, tuple(reader), reader.torn)


def parse_journal(data: bytes) -> Journal:
    """The journal in ``data``. Raises DataError when it does not begin as one."""
    reader = JournalReader(io.BytesIO(data), len(data))
    return Journal(reader.header, tuple(reader), reader.torn)


@contextlib.contextmanager
def open_journal(path: Path) -> Iterator[JournalReader]:
    """The journal in ``path``, record by record. Raises DataError when it is none."""
    try:
        file = path.open("rb")
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror or error}") from None
    with file:
        try:
            reader = JournalReader(file, path.stat().st_size)
        except DataError as error:
            raise DataError(f"{path}: {error}") from None
        yield reader


class JournalReader:
    """Iterates over the records after the header; ``torn`` is right once it has ended.

    Raises DataError when the file does not begin as a journal.
    """

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file, self._left = file, size
        head = self._take(min(len(MAGIC), size))
        if head != MAGIC:
            hint = "; it is empty, so delete it" if MAGIC.startswith(head) else ""
            raise DataError(f"not a motorid journal{hint}")
        self.torn = self._left
        first = self._record()
        if first is None or first.kind is not Kind.HEADER:
            raise DataError("the journal ends before its header: it holds nothing, so delete it")
        self.header: Mapping[str, Any] = first.json

    def __iter__(self) -> Iterator[Record]:
        while (record := self._record()) is not None:
            yield record

    def _take(self, size: int) -> bytes:
        self._left -= size
        return self._file.read(size)

    def _record(self) -> Record | None:
        """The next record, or None where it is cut short or damaged."""
        if self._left < _SMALLEST:
            return None
        head = self._take(_HEAD.size)
        if len(head) < _HEAD.size:
            return None
        kind, nanoseconds, length = _HEAD.unpack(head)
        if length + _CRC.size > self._left:
            return None
        data, check = self._take(length), self._take(_CRC.size)
        if check != _CRC.pack(zlib.crc32(data, zlib.crc32(head))):
            return None
        try:
            record = Record(Kind(kind), nanoseconds / 1e9, data)
        except ValueError:
            return None
        self.torn = self._left
        return record


def encode_record(kind: Kind, time_s: float, data: bytes) -> bytes:
    """A record's bytes."""
    body = _HEAD.pack(kind.value, max(0, round(time_s * 1e9)), len(data)) + data
    return body + _CRC.pack(zlib.crc32(body))
