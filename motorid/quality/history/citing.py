"""How many results rest on captures, by the digests of these, many at a time."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import select

from motorid.quality.history import schema as s
from motorid.quality.history.database import History

AT_ONCE = 500  # digests in a question


def results_citing(history: History, digests: Sequence[str]) -> int:
    """How many results cite any of the captures of these SHA-256. Raises DataError."""
    found: set[int] = set()
    link = s.result_captures
    with history.reading() as connection:
        for at in range(0, len(digests), AT_ONCE):
            some = digests[at : at + AT_ONCE]
            found.update(connection.scalars(select(link.c.result).where(link.c.capture.in_(some))))
    return len(found)
