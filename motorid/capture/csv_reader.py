"""Reads text tables of unknown dialect: separator, decimal comma, header lines, encoding."""

from __future__ import annotations

import contextlib
import csv
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from motorid.capture.columns import Columns, Described, unknown_column
from motorid.capture.csv_header import COMMENTS, are_units, only_unit, unit_cell, without_mark
from motorid.capture.csv_marks import Marks, looks_marked, may_be_groups
from motorid.capture.csv_numbers import MarkedError, NotPlainError, Parser
from motorid.capture.csv_settings import beside_readings, settings, settings_beside
from motorid.capture.csv_text import CSV_HEADER, Body, head, measure, opened
from motorid.capture.record_lines import moment
from motorid.errors import DataError
from motorid.limits import CSV

_SEPARATORS = (";", "\t", ",", "|")
_PROBE_LINES = 400
_NEAR = 3  # lines of the header that may speak of the columns
_PROBE = 1 << 20  # characters of them
_MAX_HEADER = CSV_HEADER
_NUMBER = re.compile(r"\s*[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\s*\Z")
_MISSING = re.compile(r"\s*(nan|inf|-inf|n/?a|null|none|-*)\s*\Z", re.IGNORECASE)


class CsvSource:
    """A text table. ``separator`` and ``decimal`` None: found from the text itself.

    ``thousands``: the mark between groups of three digits; without it no cell may have any.
    ``text``: where the text is, if not at ``path``. ``header_lines`` stand above the rows. Raises
    DataError where there is no table: an empty file, a binary one, no line of numbers.
    """

    elsewhere: str = ""

    def __init__(
        self,
        path: Path,
        separator: str | None = None,
        decimal: str | None = None,
        thousands: str | None = None,
        *,
        text: Path | None = None,
    ) -> None:
        self._text = text or path
        self._path, self._told = path, decimal is not None or thousands is not None
        decimal = decimal or {".": ",", ",": "."}.get(thousands or "")
        self._extent = measure(self._text)
        probe = head(self._text, self._extent.encoding, _PROBE_LINES, _PROBE)
        self._separator = separator or _find_separator(probe, decimal)
        self._marks = Marks(decimal or _find_decimal(probe, self._separator), thousands or "")
        rows = [self._split(line) for line in probe]
        self.header_lines = self._find_data(probe, rows)
        first = rows[self.header_lines]
        self._width = len(first)
        self._constants: dict[str, float] = {}
        if beside_readings(rows[: self.header_lines], first):
            self._constants = settings_beside(rows[: self.header_lines])
            self.header_lines = 0
        self._refuse_size()
        header = [
            without_mark(row, self._width)
            for row in rows[: self.header_lines]
            if len(row) >= min(2, self._width) and len(row) <= self._width + 1
        ]
        self._moments = {column for column, cell in enumerate(first) if moment(cell)}
        self._index: dict[str, int] = {}
        self.header_units: Mapping[str, str] = self._read_header(header)
        self._constants |= settings(rows[: self.header_lines], first)
        for name in self._constants:
            self._index.pop(name, None)  # it names a number, and no column
        self.names: Sequence[str] = [*self._index, *self._constants]
        self.constants: Mapping[str, float] = self._constants
        self.rows = max(0, self._extent.lines - self.header_lines)
        self.described: Sequence[Described] = self._describe(header)
        plural = "" if self.header_lines == 1 else "s"
        self.layout = (
            f"{self._separator!r}-separated, decimal {self._marks.decimal!r}, "
            f"{self.header_lines} header line{plural}"
        )

    def _refuse_size(self) -> None:
        lines = self._extent.lines - self.header_lines
        for count, most, what in ((self._width, CSV.columns, "columns"), (lines, CSV.rows, "rows")):
            if most is not None and count > most:
                raise DataError(
                    f"{self._path} has {count:,} {what}; a table may have {most:,}: import a part"
                )

    def place(self, row: int) -> str:
        return f"line {self.header_lines + row + 1}"

    def _split(self, line: str) -> list[str]:
        return _cells(line, self._separator)

    def _is_number(self, cell: str) -> bool:
        return (
            _is_number(cell, self._marks.decimal) or looks_marked(cell) or moment(cell) is not None
        )

    def _find_data(self, lines: list[str], rows: list[list[str]]) -> int:
        """Index of the first line of numbers; empty cells pass, so trailing separators do."""
        for index, row in enumerate(rows[:_MAX_HEADER]):
            filled = [cell for cell in row if cell]
            if filled and not lines[index].startswith(COMMENTS) and self._is_number(filled[0]):
                numeric = sum(self._is_number(cell) for cell in filled)
                if 2 * numeric > len(filled):
                    return index
        raise DataError(
            f"{self._path} has no line of numbers among its first {len(rows)}: "
            "give --separator or --decimal if it is a table"
        )

    def _read_header(self, header: list[list[str]]) -> dict[str, str]:
        """Names every column by each of its header cells; unit rows name the unit instead."""
        units: dict[int, str] = {}
        names: dict[str, list[int]] = {}
        among_units: dict[str, list[int]] = {}  # cells of a row of units, where nothing else names
        for row in header:
            filled = [cell for cell in row if cell]
            is_units = len(header) > 1 and are_units(filled)
            for column, cell in enumerate(row[: self._width]):  # one more may end the line
                cell = _unmarked(cell, column)
                unit = unit_cell(cell)
                if unit and (is_units or "(" in cell or "[" in cell):
                    units.setdefault(column, unit)
                if cell:
                    (among_units if is_units else names).setdefault(cell, []).append(column)
        names = {**among_units, **names}
        self._index = {name: found[0] for name, found in names.items() if len(set(found)) == 1}
        for column in range(self._width):  # a file without a header still has columns
            self._index.setdefault(f"column{column + 1}", column)
        for column in set(range(self._width)) - set(self._index.values()):
            self._index[f"column{column + 1} without a name"] = column  # another has its number
        units |= dict.fromkeys(self._moments, "s")
        return {name: units[column] for name, column in self._index.items() if column in units}

    def _describe(self, header: list[list[str]]) -> list[Described]:
        """Each column by the last of its header's cells that names it alone and is no unit."""
        found = []
        of_column: dict[int, list[str]] = {}
        for name, column in self._index.items():
            of_column.setdefault(column, []).append(name)
        for column in range(self._width):
            near = header[-_NEAR:]  # above them stand an instrument's settings
            cells = (_unmarked(row[column], column) for row in near if column < len(row))
            said = tuple(cell for cell in cells if cell)
            mine = of_column[column]
            names = [cell for cell in said if cell in mine] or mine
            words = [name for name in names if not only_unit(name)]
            name = (words or names)[-1]
            found.append(Described(name, said, self.header_units.get(name, "")))
        return found

    def read(self, names: Sequence[str]) -> Columns:
        import pandas as pd

        wanted = {name: self._column(name) for name in names if name not in self._constants}
        parser = Parser(self._separator, self._marks, self._width, self._moments)
        try:
            try:
                found = self._parse(parser.plain, wanted)
            except NotPlainError:
                found = self._parse(parser.careful, wanted)
            self._insist_on_one_reading(parser, found, wanted)
            stated = {n: np.array([self._constants[n]]) for n in names if n not in wanted}
            return replace(found, values={**found.values, **stated})
        except MarkedError as error:
            cell = error.cell
            raise DataError(
                f"{self._path}: {self.place(cell.row)}, column {cell.column!r} holds "
                f"{cell.text!r}, which {error.question}"
            ) from None
        except (pd.errors.ParserError, pd.errors.ParserWarning) as error:
            raise self._ragged(str(error)) from None
        except OSError as error:
            raise DataError(f"{self._path}: cannot be read: {error.strerror or error}") from None

    def _insist_on_one_reading(
        self, parser: Parser, found: Columns, wanted: Mapping[str, int]
    ) -> None:
        """Raises DataError where a mark may group thousands or not, and nobody said."""
        for name, values in found.values.items():
            if self._told or wanted[name] in self._moments or not may_be_groups(values):
                continue
            with self._body() as body:
                seen = parser.ambiguous(body, {name: wanted[name]})
            if seen.question and seen.first is not None:
                raise DataError(
                    f"{self._path}: {self.place(seen.first.row)}, column {name!r} {seen.question}"
                )

    def _parse(
        self, parse: Callable[[Body, Mapping[str, int], int], Columns], wanted: Mapping[str, int]
    ) -> Columns:
        with self._body() as body:
            return parse(body, wanted, self.rows)

    @contextlib.contextmanager
    def _body(self) -> Iterator[Body]:
        with opened(self._text, self._extent.encoding) as text:
            yield Body(text, self.header_lines, self._extent.characters)

    def _column(self, name: str) -> int:
        if name not in self._index:
            raise unknown_column(name, self.names)
        return self._index[name]

    def _ragged(self, error: str) -> DataError:
        found = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", error)
        if not found:
            return DataError(f"{self._path} is not a table: {error.strip().splitlines()[0]}")
        line = int(found[2]) + self.header_lines
        return DataError(
            f"{self._path}: line {line} has {found[3]} cells where the first data line has "
            f"{self._width}: repair that line, or give --separator"
        )


def _unmarked(cell: str, column: int) -> str:
    """A cell of a header without the mark of a comment that begins its line."""
    return cell if column else cell.lstrip("#%/ ")


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    try:
        cells = next(csv.reader([line], delimiter=separator), [])
    except csv.Error:  # a quoted cell of more than its reader takes
        return [line]
    return [cell.strip() for cell in cells]


def _is_number(cell: str, decimal: str) -> bool:
    return bool(_NUMBER.match(cell.replace(",", ".") if decimal == "," else cell))


def _is_value(cell: str) -> bool:
    """A number by any decimal mark, nothing, or a date and time."""
    return bool(
        _is_number(cell, ",")
        or _MISSING.match(cell)
        or looks_marked(cell)
        or moment(cell) is not None
    )


def _find_separator(lines: list[str], decimal: str | None) -> str:
    """The separator that cuts most lines into the same number of numeric cells."""
    best, score = "", 0
    for separator in (*_SEPARATORS, " "):
        if separator == decimal:
            continue
        rows = [_cells(line, separator) for line in lines]
        widths = [
            len(row)
            for row in rows
            if len(row) > 1 and any(cell.strip() for cell in row) and all(map(_is_value, row))
        ]
        same = max((widths.count(width) for width in set(widths)), default=0)
        if same > score:
            best, score = separator, same
    return best or ","


def _find_decimal(lines: list[str], separator: str) -> str:
    """A comma inside cells that read as numbers with it is a decimal comma."""
    if separator == ",":
        return "."
    cells = [cell for line in lines for cell in _cells(line, separator)]
    commas = sum(bool(re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell)) for cell in cells)
    points = sum(bool(re.fullmatch(r"[+-]?\d*\.\d+([eE][+-]?\d+)?", cell)) for cell in cells)
    return "," if commas > points else "."
