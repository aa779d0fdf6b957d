"""A text file of records, one a line, as columns of numbers."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import BadCell, Columns, Described, unknown_column
from motorid.capture.csv_text import measure, opened
from motorid.capture.record_lines import KINDS, STAMP, Moment, NoRecordError, moment
from motorid.errors import DataError
from motorid.limits import RECORDS, beyond, refuse_large

DAY_S = 86400.0
_NAN = float("nan")


class _Column:
    """One member: its numbers, and the first cell that holds none."""

    def __init__(self, rows_before: int) -> None:
        self.numbers = array("d", [_NAN]) * rows_before
        self.bad: tuple[int, str] | None = (0, "") if rows_before else None
        self.first: Moment | None = None  # date and time from which the others count

    def add(self, row: int, value: float | str) -> None:
        number = value if isinstance(value, float) else self._moment(value)
        if not np.isfinite(number):
            self.bad = self.bad or (row, str(value)[:40])
            number = _NAN
        self.numbers.append(number)

    def _moment(self, text: str) -> float:
        found = moment(text)
        if found is None or (self.first is None and len(self.numbers)):
            return _NAN  # no moment, or one among numbers
        self.first = self.first or found
        return found.since(self.first)


class RecordSource:
    """Records by line; a member that a line lacks is an empty cell there.

    A column of dates and times is in seconds since its first. Raises DataError beyond the limits.
    """

    elsewhere = ""

    def __init__(self, path: Path, kind: str) -> None:
        refuse_large(path, RECORDS)
        self._path, self.layout = path, kind
        self._columns: dict[str, _Column] = {}
        self._lines = array("q")  # of each record, from 1
        self._read_all(measure(path).encoding)
        units = {name: "s" for name, one in self._columns.items() if one.first is not None}
        self.header_units: Mapping[str, str] = units
        self.names: Sequence[str] = list(self._columns)
        self.constants: Mapping[str, float] = {}
        self.rows = len(self._lines)
        self.described: Sequence[Described] = [
            Described(name, (name,), units.get(name, "")) for name in self.names
        ]

    def _read_all(self, encoding: str) -> None:
        read = KINDS[self.layout]
        with opened(self._path, encoding) as text:
            for number, line in enumerate(text, 1):
                if not line.strip():
                    continue
                try:
                    self._add(read(line), number)
                except NoRecordError:
                    self._add({}, number, line.strip())
        if STAMP in self._columns:
            _past_midnight(self._columns[STAMP].numbers)

    def _add(self, record: Mapping[str, float | str], number: int, instead: str = "") -> None:
        row = len(self._lines)
        self._lines.append(number)
        for name in record:
            if name not in self._columns:
                self._columns[name] = _Column(row)
        for name, column in self._columns.items():
            column.add(row, record.get(name, instead))
        self._refuse(len(self._columns), row + 1)

    def _refuse(self, columns: int, rows: int) -> None:
        most = RECORDS
        counts = (columns, most.columns), (rows, most.rows), (columns * rows, most.numbers)
        if any(beyond(count, limit) for count, limit in counts):
            raise DataError(
                f"{self._path} has more than {most.rows:,} lines, {most.columns:,} names or "
                f"{most.numbers:,} values, the most that such a file may have: import a part"
            )

    def place(self, row: int) -> str:
        return f"line {self._lines[row]}"

    def read(self, names: Sequence[str]) -> Columns:
        values: dict[str, NDArray[np.float64]] = {}
        bad = []
        for name in names:
            if name not in self._columns:
                raise unknown_column(name, self.names)
            column = self._columns[name]
            values[name] = np.array(column.numbers, dtype=np.float64)
            if column.bad:
                bad.append(BadCell(column.bad[0], name, column.bad[1]))
        return Columns(len(self._lines), values, tuple(bad))


def _past_midnight(seconds: array[float]) -> None:
    """Counts on over midnight, where the time of the day begins anew."""
    added, before = 0.0, _NAN
    for row, now in enumerate(seconds):
        if now < before - DAY_S / 2:
            added += DAY_S
        before = now if now == now else before
        seconds[row] = now + added
