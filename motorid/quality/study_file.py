"""Gauge studies as CSV: a row a reading, with the part, the operator and one column a quantity."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from motorid.csv_text import as_written
from motorid.errors import DataError, UsageError, nearest
from motorid.limits import STUDY
from motorid.quality.gauge import Study
from motorid.reading import read_file

PART, OPERATOR = "part", "operator"
ALIASES = {
    PART: ("part", "serial", "motor"),
    OPERATOR: ("operator", "appraiser", "fixture", "station"),
}
NOT_QUANTITIES = ("trial", "repeat", "order", "time", "note", "path", "sha256", "failure")

Row = Mapping[str, str]


def read_rows(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file with a head, names in lower case only where they are a part's or an
    operator's. Raises DataError where the file cannot be read or is empty.
    """
    try:
        text = read_file(path, DataError, STUDY.file, "a study").decode("utf-8-sig")
        rows = [dict(row) for row in csv.DictReader(io.StringIO(text, newline=""), restval="")]
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f"{path} cannot be read as CSV: {error}") from None
    if any(None in row for row in rows):
        raise DataError(f"{path} has a row with more cells than its head: repair that row")
    if not rows:
        raise DataError(f"{path} holds no readings: it needs a head and a row a reading")
    return rows


def quantities_of(rows: Sequence[Row]) -> list[str]:
    """Columns that hold a number in every row and are no bookkeeping."""
    taken = {alias for names in ALIASES.values() for alias in names} | set(NOT_QUANTITIES)
    return [
        name
        for name in rows[0]
        if name and name.lower() not in taken and all(_is_number(row.get(name)) for row in rows)
    ]


def _is_number(text: str | None) -> bool:
    try:
        return math.isfinite(float(text or ""))
    except ValueError:
        return False


def column(rows: Sequence[Row], name: str, where: str) -> list[float]:
    """One column as numbers. Raises UsageError for an unknown one, DataError for a bad cell."""
    if name not in rows[0]:
        raise UsageError(f"{where} has no column {name!r}{nearest(name, list(rows[0]))}")
    for number, row in enumerate(rows, 2):
        if not _is_number(row.get(name)):
            raise DataError(f"{where}, line {number}: {name} is {row.get(name)!r}, not a number")
    return [float(row[name]) for row in rows]


def labels(rows: Sequence[Row], role: str, where: str) -> list[str]:
    """The part or the operator of every row. Raises DataError where no column says it."""
    for name in rows[0]:
        if name.strip().lower() in ALIASES[role]:
            return [as_written(row[name]).strip() for row in rows]
    raise DataError(f"{where} has no column that names the {role}: call one {role!r}")


def texts(rows: Sequence[Row], name: str, where: str) -> list[str]:
    """One column as it is written, without blanks around. Raises UsageError for an unknown one."""
    if name not in rows[0]:
        raise UsageError(f"{where} has no column {name!r}{nearest(name, list(rows[0]))}")
    return [as_written(row[name]).strip() for row in rows]


def study_of(
    rows: Sequence[Row], quantity: str, where: str, *, unit: str = "", stated: str = ""
) -> Study:
    """The crossed study of one quantity. ``stated`` names a column of standard uncertainties.

    Raises DataError where the design is not crossed or not balanced, naming the cell.
    """
    parts, operators = labels(rows, PART, where), labels(rows, OPERATOR, where)
    table = _cells(parts, operators, column(rows, quantity, where), where)
    claims = _cells(parts, operators, column(rows, stated, where), where) if stated else None
    names = tuple(dict.fromkeys(parts)), tuple(dict.fromkeys(operators))
    return Study(
        np.array([[table[p, o] for o in names[1]] for p in names[0]]),
        *names,
        quantity,
        unit,
        None if claims is None else np.array([[claims[p, o] for o in names[1]] for p in names[0]]),
    )


def nested_study_of(rows: Sequence[Row], quantity: str, where: str, *, unit: str = "") -> Study:
    """The nested study of one quantity: part k of each operator is one of its own.

    Raises DataError where operators have unlike numbers of parts or of readings.
    """
    parts, operators = labels(rows, PART, where), labels(rows, OPERATOR, where)
    own: dict[str, dict[str, list[float]]] = {}
    readings = column(rows, quantity, where)
    for part, operator, value in zip(parts, operators, readings, strict=True):
        own.setdefault(operator, {}).setdefault(part, []).append(value)
    first, *_ = own.values()
    count, repeats = len(first), len(next(iter(first.values())))
    for operator, cells in own.items():
        odd = [part for part, cell in cells.items() if len(cell) != repeats]
        if len(cells) != count or odd:
            raise DataError(
                f"{where} is no balanced nested study: {operator} has {len(cells)} parts"
                + (f" and {len(cells[odd[0]])} readings of part {odd[0]}" if odd else "")
                + f", the first has {count} parts with {repeats} readings each"
            )
    table = np.array([list(cells.values()) for cells in own.values()])
    names = tuple(" / ".join(of) for of in zip(*own.values(), strict=True))
    return Study(table.transpose(1, 0, 2), names, tuple(own), quantity, unit)


def _cells(
    parts: Sequence[str], operators: Sequence[str], values: Sequence[float], where: str
) -> dict[tuple[str, str], list[float]]:
    table: dict[tuple[str, str], list[float]] = {}
    for part, operator, value in zip(parts, operators, values, strict=True):
        table.setdefault((part, operator), []).append(value)
    most = max(len(cell) for cell in table.values())
    for part in dict.fromkeys(parts):
        for operator in dict.fromkeys(operators):
            found = len(table.get((part, operator), []))
            if found != most:
                raise DataError(
                    f"{where} is no crossed study: part {part} by {operator} has {found} readings, "
                    f"another has {most}; every operator measures every part equally often"
                )
    return table
