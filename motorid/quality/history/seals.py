"""A chain of digests over the results of each station, so that a later change of them shows.

    chain(n) = SHA-256(chain(n - 1), content(n))

The content is every column of a result, its measurements and its captures. Whoever can write the
database can write the chain anew, so heads are kept outside of it as well: ``verify`` holds them
against the chain, which also shows a tail that was cut off. Results from before there were seals
are counted, and are marked unsealed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, func, insert, select

from motorid import json_text
from motorid.quality.history import schema as s
from motorid.quality.history.records import digest

UNSEALED = "unsealed"  # in meta: how many results there were before the first seal, and the last id
START = "0" * 64


@dataclass(frozen=True)
class Head:
    """The end of a station's chain: how many results it has sealed, and their digest."""

    station: str
    position: int
    chain: str


@dataclass(frozen=True)
class Checked:
    """What ``verify`` found; ``problems`` in sentences, none where the history is as written."""

    sealed: int
    unsealed: int
    heads: tuple[Head, ...]
    problems: tuple[str, ...]


def seal(connection: Connection, result: int, station: str) -> None:
    """Adds a result that was just written to its station's chain, in the same transaction."""
    one_writer(connection)
    before = head(connection, station)
    content = content_of(connection, result)
    connection.execute(
        insert(s.seals).values(
            station=station,
            position=before.position + 1,
            result=result,
            content=content,
            chain=digest(before.chain + content),
        )
    )


def one_writer(connection: Connection) -> None:
    """Waits for its turn, where the database does not see to it itself."""
    connection.execute(select(s.meta.c.value).where(s.meta.c.name == UNSEALED).with_for_update())


def head(connection: Connection, station: str) -> Head:
    """The end of a station's chain."""
    wanted = select(s.seals).where(s.seals.c.station == station)
    last = connection.execute(wanted.order_by(s.seals.c.position.desc()).limit(1)).first()
    return Head(station, 0, START) if last is None else Head(station, last.position, last.chain)


def content_of(connection: Connection, result: int) -> str:
    """Digest of a result with all that it rests on, as the database gives it back; "": none."""
    row = connection.execute(select(s.results).where(s.results.c.id == result)).first()
    if row is None:
        return ""
    link, m = s.result_captures, s.measurements
    captures = connection.execute(
        select(s.captures)
        .join(link, link.c.capture == s.captures.c.sha256)
        .where(link.c.result == result)
        .order_by(link.c.position)
    )
    measured = connection.execute(select(m).where(m.c.result == result).order_by(m.c.name))
    said = {
        "result": _plain(row),
        "captures": [_plain(one) for one in captures],
        "measurements": sorted((_plain(one) for one in measured), key=lambda one: one["name"]),
    }
    return digest(json_text.canonical(said))


def _plain(row: Any) -> dict[str, Any]:
    return {
        name: value.isoformat() if isinstance(value, datetime) else value
        for name, value in row._mapping.items()
    }


def verify(connection: Connection, anchors: Iterable[Head] = ()) -> Checked:
    """Every seal against its result, every result against its seal, and ``anchors`` against both.

    ``anchors`` are heads that were kept elsewhere when they were the newest.
    """
    rows = connection.execute(select(s.seals).order_by(s.seals.c.station, s.seals.c.position)).all()
    problems = [*_chains(connection, rows), *_without_seal(connection, {r.result for r in rows})]
    known = {(row.station, row.position): row.chain for row in rows}
    for one in anchors:
        if known.get((one.station, one.position)) != one.chain:
            problems.append(
                f"station {one.station or 'without a name'}: result {one.position} of its chain is "
                "not the one that was sealed: the end was cut off, or the chain was written anew"
            )
    heads = {row.station: Head(row.station, row.position, row.chain) for row in rows}
    count = int(connection.scalar(select(func.count()).select_from(s.results)) or 0)
    unsealed = count - len({r.result for r in rows} & _ids(connection))
    return Checked(len(rows), unsealed, tuple(heads.values()), tuple(problems))


def _ids(connection: Connection) -> set[int]:
    return set(connection.scalars(select(s.results.c.id)))


def _chains(connection: Connection, rows: Iterable[Any]) -> Iterator[str]:
    last = Head("", 0, START)
    for row in rows:
        if row.station != last.station:
            last = Head(row.station, 0, START)
        where = f"station {row.station or 'without a name'}, result {row.result}"
        if row.position != last.position + 1:
            yield f"{where}: {row.position - last.position - 1} seals before it were deleted"
        elif row.chain != digest(last.chain + row.content):
            yield f"{where}: its seal does not follow from the one before: it was edited"
        found = content_of(connection, row.result)
        if not found:
            yield f"{where}: it was deleted"
        elif found != row.content:
            yield f"{where}: it was edited after it was sealed"
        last = Head(row.station, row.position, row.chain)


def _without_seal(connection: Connection, sealed: set[int]) -> Iterator[str]:
    said = connection.scalar(select(s.meta.c.value).where(s.meta.c.name == UNSEALED)) or "0 0"
    count, last = (int(word) for word in str(said).split())
    bare = _ids(connection) - sealed
    for result in sorted(one for one in bare if one > last):
        yield f"result {result}: it was inserted without a seal"
    older = sum(one <= last for one in bare)
    if older != count:
        yield f"there were {count} results from before the seals, and there are {older} now"
