"""A chain of digests over the rows of a table, one for each station.

    chain(n) = SHA-256(chain(n - 1), content(n))

The table has the columns station, position (from 1), content and chain.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Table, select

from motorid.quality.history.records import digest

START = "0" * 64


@dataclass(frozen=True)
class Head:
    """The end of a station's chain: how many rows it has sealed, and their digest."""

    station: str
    position: int
    chain: str

    def link(self, content: str) -> dict[str, Any]:
        """Station, position, content and chain of the row that comes next."""
        chain = digest(self.chain + content)
        return {
            "station": self.station,
            "position": self.position + 1,
            "content": content,
            "chain": chain,
        }


def head(connection: Connection, table: Table, station: str) -> Head:
    """The end of a station's chain in a table."""
    wanted = select(table).where(table.c.station == station)
    last = connection.execute(wanted.order_by(table.c.position.desc()).limit(1)).first()
    return Head(station, 0, START) if last is None else Head(station, last.position, last.chain)


def rows(connection: Connection, table: Table) -> list[Any]:
    """Every row of a table, chain by chain."""
    return list(connection.execute(select(table).order_by(table.c.station, table.c.position)))


def broken(
    found: Iterable[Any], name: Callable[[Any], str], content: Callable[[Any], str], what: str
) -> Iterator[str]:
    """What is wrong with the rows of a table, in sentences.

    ``name`` of a row; its ``content`` as it is now, "" where that is gone; ``what`` it is one of.
    """
    last = Head("", 0, START)
    for row in found:
        if row.station != last.station:
            last = Head(row.station, 0, START)
        where = f"station {row.station or 'without a name'}, {name(row)}"
        if row.position != last.position + 1:
            yield f"{where}: {row.position - last.position - 1} {what} before it were deleted"
        elif row.chain != digest(last.chain + row.content):
            yield f"{where}: its seal does not follow from the one before: it was edited"
        now = content(row)
        if not now:
            yield f"{where}: it was deleted"
        elif now != row.content:
            yield f"{where}: it was edited after it was sealed"
        last = Head(row.station, row.position, row.chain)
