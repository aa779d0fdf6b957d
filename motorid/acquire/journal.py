"""The journal: every byte of a capture as it crossed the link, on disk before it is understood.

A file is ``MAGIC`` and then records: kind (one byte), host time in nanoseconds (u64), length (u32),
the data, and the CRC-32 of all that; little-endian. It only ever grows, so that a crash can spoil
nothing but its last record.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import queue
import struct
import threading
import time
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, BinaryIO

from motorid import json_text
from motorid.acquire import lock
from motorid.acquire.port import Port
from motorid.capture.whole import sync_folder
from motorid.errors import DataError, UsageError
from motorid.limits import JOURNAL, refuse_large
from motorid.reading import open_file

MAGIC = b"motorid journal 1\n"
LONGEST_HEADER = 1 << 21  # bytes; one holds a rig file and a calibration, of 1 MiB each at most
SUFFIX = ".journal"
CLOSED = "closed"  # the key of the mark that ends a journal: size and digest of all before it
SYNC_S = 0.5  # at least once a second is promised
FLUSH_S = 0.05  # at least every 100 ms is promised
BACKLOG = 20_000  # records waiting for a slow disk before the reader waits too
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


class JournalWriter:
    """Appends records from a thread of its own, so that a slow disk does not delay heartbeats.

    Raises UsageError when the file exists (another capture writes it, or a crash left it) or cannot
    be made; ``append`` and ``close`` raise DataError once the disk has refused.
    """

    def __init__(
        self,
        path: Path,
        header: Mapping[str, Any],
        *,
        open_file: Callable[[Path], BinaryIO] | None = None,
    ) -> None:
        self.path = path
        self._error: OSError | None = None
        self._written = Digest()
        # of the simple kind, which has no lock that a writer without processor time could hold
        self._queue: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        try:
            self._file = (open_file or _create)(path)
            lock.hold(self._file)
        except FileExistsError:
            raise UsageError(
                f"{path} exists: another capture is writing it, or one was cut short; "
                f"`motorid recover {path}` keeps what it holds, --force moves it aside"
            ) from None
        except OSError as error:
            raise UsageError(f"{path} cannot be made: {error.strerror or error}") from None
        try:
            first = MAGIC + encode_record(Kind.HEADER, 0, json_text.dumps(header).encode())
            self._file.write(self._written.add(first))
            self._sync()
            sync_folder(path.parent)
        except OSError as error:
            with contextlib.suppress(OSError):  # closing tries to write again
                self._file.close()
            self.discard()
            raise DataError(f"{path} cannot be written: {error.strerror or error}") from None
        self._thread = threading.Thread(target=self._write, name="journal", daemon=True)
        self._thread.start()

    def append(self, kind: Kind, time_s: float, data: bytes) -> None:
        """Queues one record; waits only when the disk is far behind."""
        record = encode_record(kind, time_s, data)
        self._check()
        while self._queue.qsize() >= BACKLOG:
            time.sleep(FLUSH_S)
            self._check()
        self._queue.put(record)

    def mark(self, time_s: float, **what: Any) -> None:
        """Notes what the host does from here on."""
        self.append(Kind.MARK, time_s, json_text.dumps(what).encode())

    def close(self) -> None:
        """Waits until all is synced to disk. May be called twice."""
        self._queue.put(None)
        while self._thread.is_alive():
            self._thread.join(FLUSH_S)  # not for ever: Ctrl-C must be heard
        self._check()

    def discard(self) -> None:
        """Deletes the file, once its capture is safe elsewhere."""
        with contextlib.suppress(FileNotFoundError):
            self.path.unlink()

    def _check(self) -> None:
        if self._error is not None:
            reason = self._error.strerror or self._error
            raise DataError(
                f"{self.path} cannot be written any more ({reason}): the motor was stopped; make "
                f"room, then `motorid recover {self.path}` keeps what was written"
            )

    def _write(self) -> None:
        try:
            with self._file:
                self._copy()
        except OSError as error:
            self._error = error
            with contextlib.suppress(queue.Empty):  # let a waiting writer through, to be told
                while True:
                    self._queue.get_nowait()

    def _copy(self) -> None:
        synced = time.monotonic()
        open_ = True
        while open_:
            batch, open_ = self._batch()
            if not open_:
                batch += self._written.closing(batch)
            if batch:
                self._file.write(self._written.add(batch))
                self._file.flush()
            if not open_ or time.monotonic() - synced >= SYNC_S:
                self._sync()
                synced = time.monotonic()

    def _batch(self) -> tuple[bytes, bool]:
        """All that waits, and whether more may come."""
        parts: list[bytes] = []
        try:
            part = self._queue.get(timeout=FLUSH_S)
            while part is not None:
                parts.append(part)
                part = self._queue.get_nowait()
        except queue.Empty:
            return b"".join(parts), True
        return b"".join(parts), False

    def _sync(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())


class JournaledPort:
    """A port that writes down every byte that crosses it."""

    def __init__(self, port: Port, journal: JournalWriter) -> None:
        self.name = port.name
        self._port = port
        self._journal = journal

    def read(self, size: int, timeout_s: float) -> bytes:
        """See Port; raises DataError when the journal cannot be written."""
        data = self._port.read(size, timeout_s)
        if data:
            self._journal.append(Kind.RECEIVED, self.now(), data)
        return data

    def write(self, data: bytes) -> None:
        """See Port; a stop goes out even where the disk takes no note of it any more."""
        try:
            self._journal.append(Kind.SENT, self.now(), data)
        finally:
            self._port.write(data)

    def now(self) -> float:
        """See Port."""
        return self._port.now()

    def close(self) -> None:
        """Leaves the port open: it belongs to whoever opened it."""


def _create(path: Path) -> BinaryIO:
    return open(path, "xb")
