"""The day's counts: what each station judged, kept by the transaction that adds a result.

A count is of the checks of a product at a station on a day (UTC):

    test    every check
    first   first checks of a motor, for the first-pass yield
    last    newest checks of a motor, for the yield
    reason  measurements that decided a FAIL or an INVALID, with the side of their limits

A motor is a serial number of a product; checks without a number are of a motor each. Sums over any
stretch of time are those of whole days, and of the results themselves where it begins or ends
within one. ``problems`` counts all results anew.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any, NamedTuple

from sqlalchemy import (
    ColumnElement,
    Connection,
    FromClause,
    Select,
    and_,
    case,
    delete,
    exists,
    func,
    insert,
    inspect,
    literal,
    or_,
    select,
    update,
)
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.functions import FunctionElement

from motorid.quality.history import schema as s
from motorid.quality.history import turns
from motorid.quality.history.query import Query, matches
from motorid.quality.history.records import ResultRecord

CHECK = "check"  # the kind that counts
TEST, FIRST, LAST, REASON = "test", "first", "last", "reason"
LOW, HIGH = "low", "high"
PIECE = 5000  # rows in a statement


class Key(NamedTuple):
    """Whose count it is; ``name`` and ``side`` of a reason alone."""

    day: str
    product: str
    station: str
    what: str
    outcome: str
    name: str = ""
    side: str = ""


class day_of(FunctionElement[str]):  # noqa: N801 - a function of SQL
    """The day of an instant as text: 2026-11-21."""

    inherit_cache = True
    name = "day_of"


@compiles(day_of)
def _as_text(element: Any, compiler: Any, **words: Any) -> str:
    return f"substr(cast({compiler.process(element.clauses, **words)} AS char(10)), 1, 10)"


@compiles(day_of, "postgresql")
def _as_date(element: Any, compiler: Any, **words: Any) -> str:
    return f"to_char({compiler.process(element.clauses, **words)}, 'YYYY-MM-DD')"


def kept(connection: Connection) -> bool:
    """Whether this history has the counts: tables from before step 0004 do not."""
    return inspect(connection).has_table(s.tallies.name)


def add(connection: Connection, result: int, record: ResultRecord) -> None:
    """Counts a result that was just written, in the same transaction."""
    if record.kind != CHECK:
        return
    turns.of_motor(connection, record.product, record.serial)
    changes = Counter(dict(_reasons(connection, [s.results.c.id == result])))
    own = _place(record.at, record.product, record.station)
    changes[Key(*own, TEST, record.outcome)] += 1
    for what, other, passed in _others(connection, result, record):
        if other is None or passed:
            changes[Key(*own, what, record.outcome)] += 1
            if other is not None:
                there = _place(other.at, record.product, other.station)
                changes[Key(*there, what, other.outcome)] -= 1
    for key, by in sorted(changes.items()):  # rows too are locked in one order by everybody
        if by:
            _change(connection, key, by)


def _place(at: datetime, product: str, station: str) -> tuple[str, str, str]:
    return at.astimezone(UTC).date().isoformat(), product, station


def _others(
    connection: Connection, result: int, record: ResultRecord
) -> Iterator[tuple[str, Any, bool]]:
    """FIRST and LAST: the other check of the motor that was it, and whether this one passes it."""
    r = s.results.c
    same = select(r.at, r.id, r.station, r.outcome).where(
        r.serial == record.serial, r.product == record.product, r.kind == CHECK, r.id != result
    )
    own = (record.at, result)
    for what, order in ((FIRST, (r.at, r.id)), (LAST, (r.at.desc(), r.id.desc()))):
        found = record.serial and connection.execute(same.order_by(*order).limit(1)).first()
        if not found:
            yield what, None, True
        else:
            there = (found.at, found.id)
            yield what, found, own < there if what == FIRST else own > there


def _change(connection: Connection, key: Key, by: int) -> None:
    t = s.tallies
    here = and_(*(t.c[name] == value for name, value in key._asdict().items()))
    if not connection.execute(update(t).where(here).values(count=t.c.count + by)).rowcount:
        connection.execute(insert(t).values(**key._asdict(), count=by))


def recount(connection: Connection) -> None:
    """Makes the counts anew from all results."""
    turns.of_counts(connection)
    connection.execute(delete(s.tallies))
    rows = [{**key._asdict(), "count": count} for key, count in _counted(connection, []).items()]
    for begin in range(0, len(rows), PIECE):
        connection.execute(insert(s.tallies), rows[begin : begin + PIECE])


def problems(connection: Connection) -> Iterator[str]:
    """Days whose counts are not those of their results."""
    t = s.tallies
    stored = {Key(*row[:-1]): int(row[-1]) for row in connection.execute(select(t)) if row[-1]}
    counted = _counted(connection, [])
    wrong = {key for key in stored.keys() | counted if stored.get(key, 0) != counted[key]}
    for day, station in sorted({(key.day, key.station) for key in wrong}):
        yield (
            f"station {station or 'without a name'}: the counts of {day} are not those of its "
            "results: some were removed or inserted; motorid history recount takes what is there"
        )


def counts(connection: Connection, query: Query, by: Sequence[str]) -> Counter[tuple[str, ...]]:
    """Sums by some of Key's names, over product, station, since and until of ``query``.

    A serial number in it, or a history without counts, is counted from the results themselves.
    """
    r = s.results.c
    whole = None if query.serial or not kept(connection) else _whole_days(query)
    own = [r[name] == value for name in ("product", "station") if (value := getattr(query, name))]
    if query.serial:
        own.append(matches(r.serial, query.serial))
    if whole is None:
        return _summed(_counted(connection, [*own, *_within(query.since, query.until)]), by)
    found = _stored(connection, query, whole, by)
    begin, end = whole
    if query.since and query.since < begin:
        found += _summed(_counted(connection, [*own, *_within(query.since, begin)]), by)
    if query.until and query.until > end:
        found += _summed(_counted(connection, [*own, *_within(end, query.until)]), by)
    return found


def places(connection: Connection) -> tuple[list[str], list[str]]:
    """The products and the stations that are counted, each in order."""
    table = s.tallies if kept(connection) else s.results
    products, stations = (
        sorted(connection.scalars(select(table.c[name]).distinct()))
        for name in ("product", "station")
    )
    return [one for one in products if one], [one for one in stations if one]


def _within(since: datetime | None, until: datetime | None) -> list[ColumnElement[bool]]:
    at = s.results.c.at
    return [*([at >= since] if since else []), *([at < until] if until else [])]


def _whole_days(query: Query) -> tuple[datetime, datetime] | None:
    """Begin and end of the whole days of a query; None: it holds none."""
    begin = _midnight(query.since or datetime(1, 1, 1, tzinfo=UTC))
    if query.since and begin < query.since:
        begin += timedelta(days=1)
    end = _midnight(query.until or datetime(9999, 12, 31, tzinfo=UTC))
    return (begin, end) if begin < end else None


def _midnight(at: datetime) -> datetime:
    return at.astimezone(UTC).replace(hour=0, minute=0, second=0, microsecond=0)


def _stored(
    connection: Connection, query: Query, whole: tuple[datetime, datetime], by: Sequence[str]
) -> Counter[tuple[str, ...]]:
    t = s.tallies.c
    begin, end = (one.date().isoformat() for one in whole)
    asked = [t.day >= begin, t.day < end]
    asked += [
        t[name] == value for name in ("product", "station") if (value := getattr(query, name))
    ]
    wanted = select(*(t[name] for name in by), func.sum(t.count)).where(*asked)
    rows = connection.execute(wanted.group_by(*(t[name] for name in by)))
    return Counter({tuple(row[:-1]): int(row[-1]) for row in rows})


def _summed(found: Counter[Key], by: Sequence[str]) -> Counter[tuple[str, ...]]:
    sums: Counter[tuple[str, ...]] = Counter()
    for key, count in found.items():
        sums[tuple(getattr(key, name) for name in by)] += count
    return sums


# ---- from the results themselves


def _counted(connection: Connection, conditions: Sequence[ColumnElement[bool]]) -> Counter[Key]:
    """Every count of the results that meet the conditions."""
    r = s.results.alias("other")
    earlier = or_(r.c.at < s.results.c.at, _same_time(r) & (r.c.id < s.results.c.id))
    later = or_(r.c.at > s.results.c.at, _same_time(r) & (r.c.id > s.results.c.id))
    found = Counter(dict(_reasons(connection, conditions)))
    for what, only in ((TEST, []), (FIRST, [_no_other(r, earlier)]), (LAST, [_no_other(r, later)])):
        own = s.results.c
        wanted = select(day_of(own.at), own.product, own.station, literal(what), own.outcome)
        rows = connection.execute(_grouped(wanted, [*conditions, *only]))
        found.update({Key(*row[:-1]): int(row[-1]) for row in rows})
    return found


def _same_time(other: FromClause) -> ColumnElement[bool]:
    return other.c.at == s.results.c.at


def _no_other(other: FromClause, when: ColumnElement[bool]) -> ColumnElement[bool]:
    """No other check of the same motor lies there."""
    own = s.results.c
    product = func.coalesce(other.c.product, "")  # by no index: SQLite would take it, not serial's
    same = and_(other.c.serial == own.serial, product == own.product)
    there = exists().where(same, other.c.kind == CHECK, when).correlate(s.results)
    return or_(own.serial == "", ~there)


def _reasons(
    connection: Connection, conditions: Sequence[ColumnElement[bool]]
) -> Iterator[tuple[Key, int]]:
    r, m = s.results.c, s.measurements.c
    side = case(
        (or_(m.outcome != "FAIL", m.value.is_(None)), ""),
        (m.value < m.low, LOW),
        (m.value > m.high, HIGH),
        (m.high.is_(None), LOW),
        (and_(m.low.is_not(None), m.value - m.low < m.high - m.value), LOW),
        else_=HIGH,
    )
    wanted = select(
        day_of(r.at), r.product, r.station, literal(REASON), m.outcome, m.name, side.label("side")
    ).join(s.measurements, and_(m.result == r.id, m.outcome == r.outcome))
    decided = [r.outcome.in_(("FAIL", "INVALID")), *conditions]
    for row in connection.execute(_grouped(wanted, decided)):
        yield Key(*row[:-1]), int(row[-1])


def _grouped(wanted: Select[Any], conditions: Sequence[ColumnElement[bool]]) -> Select[Any]:
    columns = list(wanted.selected_columns)
    counted = wanted.add_columns(func.count()).where(s.results.c.kind == CHECK, *conditions)
    return counted.group_by(*columns)
