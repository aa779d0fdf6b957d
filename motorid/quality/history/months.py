"""Results by month, as PostgreSQL holds them: a partition for each month of their times.

    id of a result = 10^10 month + number,    month as 202611, number of one sequence

The id begins with the month, so primary keys, foreign keys and joins find the partition by the id
alone. The key that makes a result go in once is unique over all months: it stands in a table of its
own, ``result_keys``. Results from before step 0005 keep their ids, in a partition of their own.
Other databases hold all results in one table, and number them from 1.
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import (
    BigInteger,
    Column,
    ColumnElement,
    Connection,
    Engine,
    ForeignKey,
    Integer,
    MetaData,
    Table,
    bindparam,
    func,
    insert,
    literal,
    select,
)
from sqlalchemy.ext.compiler import compiles
from sqlalchemy.sql.functions import FunctionElement

from motorid.quality.history import schema as s

FIRST = 10**10  # the ids of a month; smaller ones are from before there were months
LAST_MONTH = 999_912
LOCK = 0x6D6F6E74  # shared by who adds results, alone for who makes a month
keys = Table(
    "result_keys",
    MetaData(),
    Column("key", s.DIGEST, primary_key=True),
    Column("result", BigInteger, ForeignKey(s.results.c.id), nullable=False),
)


def month_of(at: datetime) -> int:
    """2026-11-21 is 202611, as UTC has it."""
    there = at.astimezone(UTC)
    return 100 * there.year + there.month


def divided(database: Connection | Engine) -> bool:
    """Whether this database holds results by month."""
    return database.dialect.name == "postgresql"


def make(connection: Connection, at: datetime) -> None:
    """Makes the partitions of the month of ``at`` and of the next one, where they are not there.

    In a transaction of its own: it waits for all who add a result, and they for it.
    """
    next_month = (at.astimezone(UTC).replace(day=1) + timedelta(days=32)) if at.year < 9999 else at
    for month in {month_of(at), month_of(next_month)}:
        if connection.scalar(select(func.to_regclass(f"results_{month}"))) is None:
            connection.execute(select(func.motorid_month(bindparam(None, month, Integer))))


def known(connection: Connection, key: str) -> bool:
    """Whether a result is there; its month stays as it is until this transaction ends."""
    if not divided(connection):
        return connection.scalar(select(s.results.c.id).where(s.results.c.key == key)) is not None
    there = select(keys.c.result).where(keys.c.key == key).exists()
    row = connection.execute(select(there, func.pg_advisory_xact_lock_shared(LOCK))).one()
    return bool(row[0])


def add(connection: Connection, row: dict[str, Any]) -> int:
    """Inserts a row of the results, once for its key; its id. Raises IntegrityError."""
    if not divided(connection):
        done = connection.execute(insert(s.results).values(**row))
        assert done.inserted_primary_key is not None
        return int(done.inserted_primary_key[0])
    number = literal(FIRST * month_of(row["at"]), BigInteger) + func.nextval("results_id_seq")
    added = insert(s.results).values(id=number, **row).returning(s.results.c.id)
    result = int(connection.execute(added).scalar_one())
    connection.execute(insert(keys).values(key=row["key"], result=result))
    return result


class _ids_between(FunctionElement[bool]):  # noqa: N801 - a function of SQL
    """Whether an id is from before there were months, or of a range."""

    inherit_cache = True
    name = "ids_between"


@compiles(_ids_between)
def _anywhere(element: Any, compiler: Any, **words: Any) -> str:
    return "1 = 1"


@compiles(_ids_between, "postgresql")
def _in_partitions(element: Any, compiler: Any, **words: Any) -> str:
    column, low, high = (compiler.process(one, **words) for one in element.clauses)
    return f"({column} < {FIRST} OR {column} >= {low} AND {column} < {high})"


def within(
    column: ColumnElement[int], since: datetime | None, until: datetime | None
) -> list[ColumnElement[bool]]:
    """No condition of its own beside that on the time: the partitions in which it can be met."""
    if since is None and until is None:
        return []
    low = FIRST * (month_of(since) if since else 0)
    high = FIRST * ((month_of(until) if until else LAST_MONTH) + 1)
    return [_ids_between(column, literal(low, BigInteger), literal(high, BigInteger))]
