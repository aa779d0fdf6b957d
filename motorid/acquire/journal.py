"""The journal: every byte of a capture as it crossed the link, on disk before it is understood.

A file is ``MAGIC`` and then records: kind (one byte), host time in nanoseconds (u64), length (u32),
the data, and the CRC-32 of all that; little-endian. It only ever grows, so that a crash can spoil
nothing but its last record.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, BinaryIO

from motorid import json_text
from motorid.errors import DataError
from motorid.limits import JOURNAL, refuse_large
from motorid.reading import open_file

MAGIC = b"motorid journal 1\n"
LONGEST_HEADER = 1 << 21  # bytes; one holds a rig file and a calibration, of 1 MiB each at most
SUFFIX = ".journal"
CLOSED = "closed"  # the key of the mark that ends a journal: size and digest of all before it
HEAD = struct.Struct("<cQI")
CRC = struct.Struct("<I")
LONGEST_RECORD = JOURNAL.cell or 0
_SMALLEST = HEAD.size + CRC.size


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
            value = json_text.loads(self.data)
        except json_text.JsonError:
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
    refuse_large(path, JOURNAL)
    with open_file(path, DataError) as file:
        try:
            reader = JournalReader(file, path.stat().st_size)
        except DataError as error:
            raise DataError(f"{path}: {error}") from None
        yield reader


class JournalReader:
    """Iterates over the records between the header and the mark that closes the journal.

    ``torn`` is right once it has ended.

    Raises DataError when the file does not begin as a journal.
    """

    def __init__(self, file: BinaryIO, size: int) -> None:
        self._file, self._left = file, size
        head = self._take(min(len(MAGIC), size))
        if head != MAGIC:
            if MAGIC.startswith(head):
                raise DataError("not a motorid journal; it is empty, so delete it")
            raise DataError("not a motorid journal, or damaged in its first line")
        self.torn = self._left
        first = self._record()
        if first is None or first.kind is not Kind.HEADER:
            whole = first is not None or self.torn - self._left > HEAD.size
            if whole or self.torn > LONGEST_HEADER:
                raise DataError("the journal's header is damaged: keep it, and take another copy")
            raise DataError("the journal ends before its header: it holds nothing, so delete it")
        self.header: Mapping[str, Any] = first.json

    def __iter__(self) -> Iterator[Record]:
        while (record := self._record()) is not None:
            if record.kind is not Kind.MARK or CLOSED not in record.json:
                yield record

    def _take(self, size: int) -> bytes:
        self._left -= size
        return self._file.read(size)

    def _record(self) -> Record | None:
        """The next record, or None where it is cut short or damaged."""
        if self._left < _SMALLEST:
            return None
        head = self._take(HEAD.size)
        if len(head) < HEAD.size:
            return None
        kind, nanoseconds, length = HEAD.unpack(head)
        if length + CRC.size > self._left or length > LONGEST_RECORD:
            return None
        data, check = self._take(length), self._take(CRC.size)
        if check != CRC.pack(zlib.crc32(data, zlib.crc32(head))):
            return None
        try:
            record = Record(Kind(kind), nanoseconds / 1e9, data)
        except ValueError:
            return None
        self.torn = self._left
        return record


def encode_record(kind: Kind, time_s: float, data: bytes) -> bytes:
    """A record's bytes."""
    body = HEAD.pack(kind.value, max(0, round(time_s * 1e9)), len(data)) + data
    return body + CRC.pack(zlib.crc32(body))


class Digest:
    """The SHA-256 of a journal as it is written, for the mark that closes it."""

    def __init__(self) -> None:
        self._sha256 = hashlib.sha256()
        self._size = 0

    def add(self, data: bytes) -> bytes:
        """Takes what is written next; returns it."""
        self._sha256.update(data)
        self._size += len(data)
        return data

    def closing(self, last: bytes) -> bytes:
        """The record that ends a journal after ``last``, which was not added yet."""
        sha256 = self._sha256.copy()
        sha256.update(last)
        what = {CLOSED: {"bytes": self._size + len(last), "sha256": sha256.hexdigest()}}
        return encode_record(Kind.MARK, 0, json_text.dumps(what).encode())
