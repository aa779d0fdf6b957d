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
from motorid.quality.history import chain, names, turns
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
    turns.of_chain(connection, "trail", entry.station)
    if connection.scalar(select(s.trail.c.key).where(s.trail.c.key == key)) is not None:
        return False
    row = {name: getattr(entry, name) for name in SAID if name != "who"}
    row["who"] = names.cite(connection, entry.who, entry.at)
    link = chain.head(connection, s.trail, entry.station).link(_content(row))
    connection.execute(insert(s.trail).values(key=key, **link, **row))
    return True


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
    yield from chain.broken(
        chain.rows(connection, s.trail),
        lambda row: f"entry {row.position} of the trail",
        lambda row: _content(row._mapping),
        "entries",
    )
    yield from names.problems(connection, forgotten_before(connection))


def shown(connection: Connection, entries: Sequence[Any]) -> list[dict[str, Any]]:
    """Rows of the trail as a person reads them, with names as far as they are kept."""
    known = names.names_of(connection, {row.who for row in entries})
    return [{**row._mapping, "who": known[row.who]} for row in entries]
