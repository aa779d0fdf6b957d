"""The trail: who ordered what, and what was done to the history itself, in a chain of digests.

Each station has a chain of its own, as its results have (see seals.py). Names are cited, so that
they can be forgotten and the chain still holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, insert, select

from motorid import json_text
from motorid.quality.history import names, seals
from motorid.quality.history import schema as s
from motorid.quality.history.records import digest

ORDER, FORGET, RULE = "order", "forget names", "keep names"
DONE = "done"
SAID = ("at", "action", "outcome", "who", "subject", "reason")  # what a content is the digest of


@dataclass(frozen=True)
class Entry:
    """``outcome``: accepted, refused or done; ``who`` a person, or where an order came from.

    ``subject``: a serial number; the instant before which names were forgotten; how long they stay.
    ``key`` tells two entries apart that say the same, and makes each go in once.
    """

    action: str
    outcome: str
    who: str
    key: str
    subject: str = ""
    reason: str = ""
    station: str = ""
    at: datetime = field(default_factory=lambda: datetime.now(UTC))


def add(connection: Connection, entry: Entry) -> bool:
    """Writes an entry at the end of its station's chain; False where it is there already."""
    key = digest(entry.key)
    seals.one_writer(connection)
    if connection.scalar(select(s.trail.c.key).where(s.trail.c.key == key)) is not None:
        return False
    row = {name: getattr(entry, name) for name in SAID if name != "who"}
    row["who"] = names.cite(connection, entry.who, entry.at)
    before = head(connection, entry.station)
    content = _content(row)
    connection.execute(
        insert(s.trail).values(
            station=entry.station,
            position=before.position + 1,
            key=key,
            content=content,
            chain=digest(before.chain + content),
            **row,
        )
    )
    return True


def head(connection: Connection, station: str) -> seals.Head:
    """The end of a station's chain."""
    wanted = select(s.trail).where(s.trail.c.station == station)
    last = connection.execute(wanted.order_by(s.trail.c.position.desc()).limit(1)).first()
    if last is None:
        return seals.Head(station, 0, seals.START)
    return seals.Head(station, last.position, last.chain)


def _content(row: Any) -> str:
    at = row["at"].astimezone(UTC).isoformat()
    return digest(json_text.canonical({**{name: row[name] for name in SAID}, "at": at}))


def forgotten_before(connection: Connection) -> datetime | None:
    """The latest instant before which names were forgotten; None: none were."""
    wanted = select(s.trail.c.subject).where(s.trail.c.action == FORGET)
    found = [datetime.fromisoformat(one) for one in connection.scalars(wanted)]
    return max(found, default=None)


def problems(connection: Connection) -> Iterator[str]:
    """Entries that were edited, deleted or inserted, and names likewise."""
    last = seals.Head("", 0, seals.START)
    rows = connection.execute(select(s.trail).order_by(s.trail.c.station, s.trail.c.position))
    for row in rows:
        if row.station != last.station:
            last = seals.Head(row.station, 0, seals.START)
        where = f"station {row.station or 'without a name'}, entry {row.position} of the trail"
        if row.position != last.position + 1:
            yield f"{where}: {row.position - last.position - 1} entries before it were deleted"
        elif row.chain != digest(last.chain + row.content):
            yield f"{where}: it does not follow from the one before: it was edited"
        if row.content != _content(row._mapping):
            yield f"{where}: it was edited after it was sealed"
        last = seals.Head(row.station, row.position, row.chain)
    yield from names.problems(connection, forgotten_before(connection))


def shown(connection: Connection, entries: Sequence[Any]) -> list[dict[str, Any]]:
    """Rows of the trail as a person reads them, with names as far as they are kept."""
    return [{**row._mapping, "who": names.name_of(connection, row.who)} for row in entries]
