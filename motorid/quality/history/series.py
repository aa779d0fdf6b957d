"""The readings of one quantity by time: as rows, or as arrays where there are a million of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection, DateTime, Double, Select, select, type_coerce

from motorid.quality.history import months
from motorid.quality.history import schema as s
from motorid.quality.history.query import Query

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PIECE = 20_000  # rows that are in memory at a time


def chosen(name: str, query: Query, last: int | None) -> Select[Any]:
    """Rows (at, serial, value, uncertainty, low, high, unit), only the ``last`` ones if asked."""
    m, r = s.measurements, s.results
    of_these = (*query.conditions(), m.c.name == name, m.c.value.is_not(None))
    wanted = (
        select(r.c.at, r.c.serial, m.c.value, m.c.uncertainty, m.c.low, m.c.high, m.c.unit)
        .join(r, r.c.id == m.c.result)
        .where(*of_these, *months.within(m.c.result, query.since, query.until))
        .order_by(r.c.at, r.c.id)
    )
    if last is None:
        return wanted
    # walks back in time, instead of sorting every result
    there = select(m.c.result).where(m.c.result == r.c.id, *of_these).correlate(r).exists()
    newest = select(r.c.id).where(there).order_by(r.c.at.desc(), r.c.id.desc()).limit(last)
    return wanted.where(r.c.id.in_(select(newest.subquery().c.id)))


def arrays(
    connection: Connection, name: str, query: Query, last: int | None
) -> tuple[NDArray[np.datetime64], NDArray[np.float64]]:
    """Times (UTC) and values of the same rows. Raises ValueError for what is no time or number."""
    import numpy as np

    bare = chosen(name, query, last).with_only_columns(
        type_coerce(s.results.c.at, DateTime), type_coerce(s.measurements.c.value, Double)
    )
    times, values = [np.empty(0, "datetime64[us]")], [np.empty(0)]
    rows = connection.execution_options(yield_per=PIECE).execute(bare)
    for piece in rows.partitions():
        at, value = zip(*piece, strict=True)
        times.append(np.array(at, "datetime64[us]"))
        values.append(np.array(value, float))
        if not np.isfinite(values[-1]).all():
            raise ValueError(f"a reading of {name} is no finite number: it is damaged")
    return np.concatenate(times), np.concatenate(values)
