"""Run as a program: a spreadsheet -> the text of its sheet with most numbers (capture/child.py)."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date, datetime, time, timedelta
from typing import Any

import numpy as np

from motorid.capture.child import serve
from motorid.errors import DataError
from motorid.limits import SHEET, beyond

SEPARATOR = "\t"
_BLANKS = str.maketrans("\t\r\n\v\f\x85\u2028\u2029", " " * 8)


def main(source: str, target: str) -> None:
    """Reads ``source`` and writes ``target``: the text, the sheet's name, the other sheets' names.

    Raises what the library raises, DataError beyond the limits.
    """
    try:
        from python_calamine import CalamineWorkbook
    except ImportError:
        raise DataError(
            "spreadsheets need the package python-calamine: pip install 'motorid[xlsx]'"
        ) from None
    book = CalamineWorkbook.from_path(source)
    best, most, text = "", -1, ""
    for name in book.sheet_names:
        sheet = book.get_sheet_by_name(name)
        refuse_shape(name, sheet.total_height, sheet.total_width)
        rows = sheet.to_python(skip_empty_area=False)
        numbers = sum(isinstance(cell, int | float) for row in rows for cell in row)
        if numbers > most:
            best, most, text = name, numbers, as_text(rows)
    others = [name for name in book.sheet_names if name != best]
    np.savez(
        target, text=np.frombuffer(text.encode("utf-8", "replace"), dtype=np.uint8),
        sheet=np.array([best], dtype=str), others=np.array(others, dtype=str),
    )  # fmt: skip


def refuse_shape(name: str, rows: int, columns: int) -> None:
    """Raises DataError for a sheet that is larger than the limits allow."""
    most = SHEET
    if beyond(columns, most.columns) or beyond(rows * columns, most.numbers):
        raise DataError(
            f"sheet {name!r} has {rows:,} rows of {columns:,} columns; a sheet may have "
            f"{most.columns:,} columns and {most.numbers:,} cells: save a part of it"
        )


def as_text(rows: Sequence[Sequence[Any]]) -> str:
    """Rows as lines, cells by tabs; numbers with every digit, dates and times as ISO 8601."""
    return "".join(SEPARATOR.join(map(_cell, row)) + "\n" for row in rows)


def _cell(value: Any) -> str:
    match value:
        case bool():
            return str(int(value))
        case int() | float():
            return f"{value:.15g}"
        case datetime() | date():
            return value.isoformat()
        case time():
            day = timedelta(
                hours=value.hour, minutes=value.minute, seconds=value.second,
                microseconds=value.microsecond,
            )  # fmt: skip
            return f"{day.total_seconds():.15g}"
        case timedelta():
            return f"{value.total_seconds():.15g}"
    return str(value).translate(_BLANKS).replace("\0", "").replace('"', "'").strip()


if __name__ == "__main__":
    serve(main, ("numpy", "datetime"))
