"""Writes a journal while bytes cross the link, and never lets go of what it holds."""

from __future__ import annotations

import contextlib
import os
import queue
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from motorid import json_text
from motorid.acquire import journal_place, lock
from motorid.acquire.journal import MAGIC, Digest, Kind, encode_record
from motorid.acquire.link import Port
from motorid.acquire.outputs import in_the_way
from motorid.capture.whole import sync_folder
from motorid.errors import DataError, UsageError

SYNC_S = 0.5  # at least once a second is promised
FLUSH_S = 0.05  # at least every 100 ms is promised
BACKLOG = 20_000  # records waiting for a slow disk before the reader waits too


class JournalWriter:
    """Appends records from a thread of its own, so that a slow disk does not delay heartbeats.

    ``path`` is where the journal is; it changes where its name is removed while it is written.
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
        self._wanted = Path(os.path.abspath(path))
        self._error: OSError | None = None
        self._written = Digest()
        # of the simple kind, which has no lock that a writer without processor time could hold
        self._queue: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        try:
            self._file = (open_file or journal_place.create)(path)
            lock.hold(self._file)
        except FileExistsError:
            raise UsageError(in_the_way(path)) from None
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
            self.path.unlink(missing_ok=True)
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
            if not self._thread.is_alive():
                raise DataError(f"{self.path} is no longer written: the motor was stopped")
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
        """Deletes the file, once it holds nothing that is not safe elsewhere."""
        self.path.unlink(missing_ok=True)

    def _check(self) -> None:
        if self._error is not None:
            reason = self._error.strerror or self._error
            raise DataError(
                f"{self.path} cannot be written any more ({reason}): the motor was stopped; make "
                f"room, then `motorid recover {self.path}` keeps what was written"
            )

    def _write(self) -> None:
        try:
            try:
                self._copy()
            finally:
                self._file.close()
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
                self._stay_named(last=not open_)
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

    def _stay_named(self, *, last: bool) -> None:
        """Goes on in a copy where somebody removed the name; an open file has no other way back.

        Raises OSError where no folder takes it, and this is the ``last`` chance.
        """
        if journal_place.is_named(self._file, self.path):
            return
        try:
            self._file, self.path = journal_place.copy_elsewhere(self._file, self._wanted)
        except OSError:
            if last:
                raise


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
