"""Where comparisons of stations get their readings and verdicts: a history, or a CSV file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid.errors import DataError, UsageError, nearest

if TYPE_CHECKING:
    from motorid.quality.history import History, Query
    from motorid.quality.stations import Reading


def verdicts_from_history(where: str, query: Query) -> tuple[list[str], list[str], list[str]]:
    """Motor, station and verdict of each result that ``query`` chooses.

    Raises DataError where none names its station.
    """
    from motorid.quality.history import open_history

    with open_history(where, create=False) as history:
        rows = _named(history, query, where)
    return [r.serial for r in rows], [r.station for r in rows], [r.outcome for r in rows]


def _named(history: History, query: Query, where: str) -> list[Any]:
    """The results that name their station."""
    rows = [row for row in history.results(query) if row.station]
    if not rows:
        raise DataError(
            f"{where} has no such result that names its station: widen the query, or give each "
            "station its --station NAME"
        )
    return rows


def from_csv(path: Path, quantity: str) -> list[Reading]:
    """Rows with part, station (or fixture, operator) and value; ``u(QUANTITY)``, if there."""
    from motorid.quality.stations import Reading
    from motorid.quality.study_file import OPERATOR, PART, column, labels, quantities_of, read_rows

    rows, where = read_rows(path), str(path)
    values = column(rows, quantity, where)
    claim = f"u({quantity})"
    stated: list[float | None] = [None] * len(rows)
    if claim in quantities_of(rows):
        stated = list(column(rows, claim, where))
    named = zip(
        labels(rows, OPERATOR, where), labels(rows, PART, where), values, stated, strict=True
    )
    return [Reading(*one) for one in named]


def from_history(where: str, quantity: str, query: Query) -> tuple[list[Reading], str]:
    """What each station of a history read of the motors that ``query`` chooses, and the unit.

    Raises UsageError for a quantity that was never measured, DataError for no result.
    """
    from motorid.quality.history import open_history
    from motorid.quality.stations import Reading

    with open_history(where, create=False) as history:
        names = history.names()
        if quantity not in names:
            raise UsageError(f"{where} never measured {quantity!r}{nearest(quantity, names)}")
        stations = dict.fromkeys(row.station for row in _named(history, query, where))
        found = {s: history.series(quantity, replace(query, station=s)) for s in stations}
    readings = [
        Reading(station, row.serial, row.value, row.uncertainty)
        for station, rows in found.items()
        for row in rows
    ]
    if not readings:
        raise DataError(f"{where} has no such result with {quantity}: widen the query")
    return readings, next(row.unit for rows in found.values() for row in rows)
