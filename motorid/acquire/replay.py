"""replay://JOURNAL: a board's bytes played back, so that a field problem can be run again."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motorid.acquire.header import check_kinds
from motorid.acquire.journal import Kind, read_journal
from motorid.errors import LinkError

PATIENCE_S = 1.0  # how late the client may be with bytes that the journal says it sent


class ReplayPort:
    """Gives back the received bytes of a journal, read by read, once what preceded them was sent.

    The clock stands at the record last played, so that the client's time-outs and heartbeats fall
    where they fell. Raises DataError when the journal cannot be read, LinkError at its end.
    """

    def __init__(self, path: str) -> None:
        self.name = f"replay://{path}"
        journal = read_journal(Path(path))
        self.header: Mapping[str, Any] = journal.header
        marks = [r.json for r in journal.records if r.kind is Kind.MARK]
        for found in (self.header, *marks):
            check_kinds(found, f"{path}: a header or mark")
        ends = [mark["end"] for mark in marks if "end" in mark]
        self.end: str | None = ends[-1] if ends else None
        self._records = [r for r in journal.records if r.kind is not Kind.MARK]
        self._at = 0
        self._owed = 0  # bytes that the client wrote ahead of the journal
        self._now = self._records[0].time_s if self._records else 0.0

    def read(self, size: int, timeout_s: float) -> bytes:
        """See Port: the next record's bytes; nothing where the board was waiting for the host."""
        self._pass_sent()
        if self._at == len(self._records):
            raise LinkError(f"{self.name}: the journal ends here")
        record = self._records[self._at]
        if record.kind is Kind.SENT or record.time_s > self._now + timeout_s:
            self._now += timeout_s
            return b""
        self._now = max(self._now, record.time_s)
        self._at += 1
        return record.data

    def write(self, data: bytes) -> None:
        """See Port: steps over the bytes that the journal says were sent."""
        self._owed += len(data)
        self._pass_sent()

    def _pass_sent(self) -> None:
        """Steps over sent records that the client has sent too, or is late with."""
        while self._at < len(self._records) and self._records[self._at].kind is Kind.SENT:
            record = self._records[self._at]
            if len(record.data) > self._owed and self._now < record.time_s + PATIENCE_S:
                return
            self._owed = max(0, self._owed - len(record.data))
            self._at += 1

    def now(self) -> float:
        """See Port."""
        return self._now

    def close(self) -> None:
        """See Port: nothing is held."""
