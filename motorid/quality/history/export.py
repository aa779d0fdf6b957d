"""The history as one flat table, a row a measurement: CSV for people, Parquet for analysis."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sqlalchemy import select

from motorid import csv_text
from motorid.capture.whole import write_whole
from motorid.errors import DataError, UsageError
from motorid.quality.history import schema as s
from motorid.quality.history.database import History
from motorid.quality.history.query import Query

CHUNK = 20_000
RESULT_COLUMNS = ("id", "at", "kind", "serial", "product", "outcome", "marginal", "station")
MEASUREMENT_COLUMNS = tuple(c.name for c in s.measurements.columns if c.name != "result")
FLAGS, NUMBERS = ("marginal",), ("value", "uncertainty", "low", "high", "guard_band")


def columns() -> list[str]:
    """Names of the table's columns: the result's own, the measurement's, the first capture's."""
    own = [f"result_{n}" if n in MEASUREMENT_COLUMNS else n for n in RESULT_COLUMNS]
    return [*own, *MEASUREMENT_COLUMNS, "capture_sha256", "capture_path"]


def rows(history: History, query: Query) -> Iterator[list[tuple[Any, ...]]]:
    """The table in pieces, oldest first."""
    r, m, link, c = s.results, s.measurements, s.result_captures, s.captures
    first = (link.c.result == r.c.id) & (link.c.position == 0)
    wanted = (
        select(
            *(r.c[name] for name in RESULT_COLUMNS),
            *(m.c[name] for name in MEASUREMENT_COLUMNS),
            c.c.sha256,
            c.c.path,
        )
        .join(m, m.c.result == r.c.id)
        .outerjoin(link, first)
        .outerjoin(c, c.c.sha256 == link.c.capture)
    )
    with history.reading() as connection:
        found = connection.execution_options(yield_per=CHUNK).execute(
            query.apply(wanted).order_by(m.c.name)
        )
        for piece in found.partitions(CHUNK):
            yield [tuple(row) for row in piece]


def export(history: History, path: Path, query: Query | None = None, *, force: bool = False) -> int:
    """Writes the table to ``path``, ``.csv`` or ``.parquet``; returns the number of rows.

    Raises UsageError for another ending, an existing file, or Parquet without pyarrow.
    """
    writers = {".csv": _csv, ".parquet": _parquet}
    if path.suffix.lower() not in writers:
        raise UsageError(f"{path} ends in none of {', '.join(writers)}: that says the format")
    data, count = writers[path.suffix.lower()](rows(history, query or Query()))
    write_whole(path, data, force=force)
    return count


def _csv(pieces: Iterator[list[tuple[Any, ...]]]) -> tuple[bytes, int]:
    rows = [[_plain(value) for value in row] for piece in pieces for row in piece]
    return csv_text.table(columns(), rows).encode(), len(rows)


def _plain(cell: Any) -> Any:
    return cell.isoformat() if hasattr(cell, "isoformat") else cell


def _parquet(pieces: Iterator[list[tuple[Any, ...]]]) -> tuple[bytes, int]:
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ModuleNotFoundError:
        raise UsageError(
            "Parquet needs the package pyarrow: pip install 'motorid[parquet]', or export .csv"
        ) from None
    schema = pa.schema([(name, _arrow_type(pa, name)) for name in columns()])
    sink, count = io.BytesIO(), 0
    with parquet.ParquetWriter(sink, schema) as writer:
        for piece in pieces:
            cells = [map(csv_text.cell, row) for row in piece]
            table = dict(zip(columns(), map(list, zip(*cells, strict=True)), strict=True))
            try:
                writer.write_table(pa.table(table, schema=schema))
            except (pa.ArrowException, TypeError, OverflowError) as error:
                raise DataError(f"the history is damaged: {error}") from None
            count += len(piece)
    return sink.getvalue(), count


def _arrow_type(pa: Any, name: str) -> Any:
    if name == "id":
        return pa.int64()
    if name == "at":
        return pa.timestamp("us", tz="UTC")
    if name.removeprefix("result_") in FLAGS:
        return pa.bool_()
    return pa.float64() if name in NUMBERS else pa.string()
