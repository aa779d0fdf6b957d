"""A chain of digests over the results of each station, so that a later change of them shows.

The chain is chain.py's. The content is every column of a result, its measurements and its captures.
Whoever can write the database can write the chain anew, so heads are kept outside of it as well:
``verify`` holds them against the chain, which also shows a tail that was cut off. Results from
before there were seals are counted, and are marked unsealed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, func, insert, select

from motorid import json_text
from motorid.quality.history import chain, turns
from motorid.quality.history import schema as s
from motorid.quality.history.chain import Head
from motorid.quality.history.records import digest

UNSEALED = "unsealed"  # in meta: how many results there were before the first seal, and the last id


@dataclass(frozen=True)
class Checked:
    """What ``verify`` found; ``problems`` in sentences, none where the history is as written."""

    sealed: int
    unsealed: int
    heads: tuple[Head, ...]
    problems: tuple[str, ...]


def seal(connection: Connection, result: int, station: str) -> None:
    """Adds a result that was just written to its station's chain, in the same transaction."""
    turns.of_chain(connection, "seals", station)
    link = chain.head(connection, s.seals, station).link(content_of(connection, result))
    connection.execute(insert(s.seals).values(result=result, **link))


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
    rows = chain.rows(connection, s.seals)
    problems = [
        *chain.broken(
            rows,
            lambda row: f"result {row.result}",
            lambda row: content_of(connection, row.result),
            "seals",
        ),
        *_without_seal(connection, {row.result for row in rows}),
    ]
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


def _without_seal(connection: Connection, sealed: set[int]) -> Iterator[str]:
    said = connection.scalar(select(s.meta.c.value).where(s.meta.c.name == UNSEALED)) or "0 0"
    count, last = (int(word) for word in str(said).split())
    bare = _ids(connection) - sealed
    for result in sorted(one for one in bare if one > last):
        yield f"result {result}: it was inserted without a seal"
    older = sum(one <= last for one in bare)
    if older != count:
        yield f"there were {count} results from before the seals, and there are {older} now"
