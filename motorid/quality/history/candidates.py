"""Results whose outcome other limits may change, found by the database in one walk.

All others passed, and pass by the new limits: each of their values lies inside by more than any
guard band of the rule. No row of theirs leaves the database.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from math import isinf
from typing import Any

from sqlalchemy import ColumnElement, Row, Select, and_, case, func, select

from motorid.quality.history import schema as s
from motorid.quality.history.database import History
from motorid.quality.history.query import Query
from motorid.quality.limits import Limit
from motorid.quality.stored_verdict import Stored, surely_within

PIECE = 500  # results whose measurements are read at once
r, m = s.results.c, s.measurements.c


def bounds(history: History, query: Query, count: int) -> list[tuple[int, int]]:
    """Ranges (from, to] of ids that hold all results of ``query``; ``count`` of all in each."""
    with history.reading() as connection:
        chosen = select(func.min(r.id), func.max(r.id)).where(*query.conditions())
        least, most = connection.execute(chosen).one()
        if least is None:
            return []
        found, low = [], int(least) - 1
        while low < most:
            there = select(r.id).where(r.id > low, r.id <= most).order_by(r.id)
            high = connection.scalar(there.offset(count - 1).limit(1)) or most
            found.append((low, int(high)))
            low = int(high)
    return found


def candidates(
    history: History, query: Query, limits: Mapping[str, Limit], ids: tuple[int, int]
) -> Iterator[tuple[Row[Any], list[Stored]]]:
    """Each with its measurements, of the ids in a range (from, to]."""
    within = (m.result > ids[0], m.result <= ids[1])
    passes = and_(s.measurements.c.outcome == "PASS", _inside(limits))
    judged = func.sum(case((m.name.in_(limits), 1), else_=0))
    grouped = select(m.result).join(s.results, r.id == m.result)
    grouped = grouped.where(*query.conditions(), *within, r.id > ids[0], r.id <= ids[1])
    doubtful = grouped.group_by(m.result).having(
        (func.min(case((passes, 1), else_=0)) == 0) | (judged < len(limits))
    )
    with history.reading() as connection:
        found = list(connection.scalars(doubtful.order_by(m.result)))
        for begin in range(0, len(found), PIECE):
            some = found[begin : begin + PIECE]
            results = {one.id: one for one in connection.execute(_results(some))}
            for number, rows in groupby(connection.execute(_stored(some)), lambda one: one.result):
                yield results[number], [Stored(*row[1:]) for row in rows]


def _results(numbers: Sequence[int]) -> Select[Any]:
    return select(r.id, r.at, r.serial, r.station, r.outcome).where(r.id.in_(numbers))


def _stored(numbers: Sequence[int]) -> Select[Any]:
    columns = (m.result, m.name, m.unit, m.value, m.uncertainty, m.outcome, m.reason)
    return select(*columns).where(m.result.in_(numbers)).order_by(m.result, m.name)


def _inside(limits: Mapping[str, Limit]) -> ColumnElement[bool]:
    """Whether a measurement is accepted for sure; of another name than ``limits`` have: yes."""
    sure = [(m.name == name, _by(limit)) for name, limit in limits.items()]
    return case(*sure, else_=1) == 1


def _by(limit: Limit) -> ColumnElement[int]:
    width = surely_within(limit.rule) * m.uncertainty
    ends = [m.uncertainty >= 0.0, m.value.is_not(None)]
    ends += [] if isinf(limit.low) else [m.value - width >= limit.low]
    ends += [] if isinf(limit.high) else [m.value + width <= limit.high]
    return case((and_(*ends), 1), else_=0)
