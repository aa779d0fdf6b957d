"""Reads text tables of unknown dialect: separator, decimal comma, header lines, encoding."""

from __future__ import annotations

import csv
import io
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import BadCell, Columns, unknown_column
from motorid.capture.units import spelled
from motorid.errors import DataError
from motorid.reading import read_file

Floats = NDArray[np.float64]
_SEPARATORS = (";", "\t", ",", "|")
_COMMENT = ("#", "%", "//")
MAX_BYTES = 1 << 32
_PROBE_LINES = 400
_MAX_HEADER = 100
_NUMBER = re.compile(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*\Z")
_MISSING = re.compile(r"\s*(nan|inf|-inf|n/?a|null|none|-*)\s*\Z", re.IGNORECASE)


class CsvSource:
    """A text table. ``separator`` and ``decimal`` None: found from the text itself.

    Raises DataError where there is no table: an empty file, a binary one, no line of numbers.
    """

    def __init__(self, path: Path, separator: str | None = None, decimal: str | None = None):
        self._path = path
        self._text = _decode(path)
        probe = _head(self._text, _PROBE_LINES)
        self._separator = separator or _find_separator(probe, decimal)
        self._decimal = decimal or _find_decimal(probe, self._separator)
        rows = [self._split(line) for line in probe]
        self._header_lines = self._find_data(probe, rows)
        self._width = len(rows[self._header_lines])
        header = [
            row
            for row in rows[: self._header_lines]
            if len(row) >= min(2, self._width) and len(row) <= self._width + 1
        ]
        self._index: dict[str, int] = {}
        self.header_units: Mapping[str, str] = self._read_header(header)
        self.names: Sequence[str] = list(self._index)
        plural = "" if self._header_lines == 1 else "s"
        self.layout = (
            f"{self._separator!r}-separated, decimal {self._decimal!r}, "
            f"{self._header_lines} header line{plural}"
        )

    def place(self, row: int) -> str:
        return f"line {self._header_lines + row + 1}"

    def _split(self, line: str) -> list[str]:
        if self._separator == " ":
            return line.split()
        try:
            cells = next(csv.reader([line], delimiter=self._separator), [])
        except (csv.Error, TypeError) as error:
            raise DataError(
                f"{self._path} cannot be read as a table separated by {self._separator!r} "
                f"({error}): repair that cell, or give --separator"
            ) from None
        return [cell.strip() for cell in cells]

    def _is_number(self, cell: str) -> bool:
        return _is_number(cell, self._decimal)

    def _find_data(self, lines: list[str], rows: list[list[str]]) -> int:
        """Index of the first line of numbers; empty cells pass, so trailing separators do."""
        for index, row in enumerate(rows[:_MAX_HEADER]):
            filled = [cell for cell in row if cell]
            if filled and not lines[index].startswith(_COMMENT) and self._is_number(filled[0]):
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
        for row in header:
            filled = [cell for cell in row if cell]
            is_units = len(header) > 1 and filled and all(spelled(c) or c == "-" for c in filled)
            for column, cell in enumerate(row[: self._width]):  # one more may end the line
                cell = cell.lstrip("#%/ ") if not column else cell
                unit = spelled(cell)
                if unit and (is_units or "(" in cell or "[" in cell):
                    units.setdefault(column, unit)
                if cell and not is_units:
                    names.setdefault(cell, []).append(column)
        self._index = {name: found[0] for name, found in names.items() if len(set(found)) == 1}
        for column in range(self._width):  # a file without a header still has columns
            self._index.setdefault(f"column{column + 1}", column)
        return {name: units[column] for name, column in self._index.items() if column in units}

    def read(self, names: Sequence[str]) -> Columns:
        import pandas as pd

        indices = [self._column(name) for name in names]
        data = self._text.split("\n", self._header_lines)[-1] if self._header_lines else self._text
        try:
            with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):
                frame = pd.read_csv(
                    io.StringIO(data.rstrip()),
                    sep=r"\s+" if self._separator == " " else self._separator,
                    header=None,
                    names=list(range(self._width)),
                    index_col=False,
                    dtype=object,  # plain strings: three times as fast as text of pandas' own
                    keep_default_na=False,
                    skip_blank_lines=False,
                    on_bad_lines="error",
                )
        except (pd.errors.ParserError, pd.errors.ParserWarning) as error:
            raise self._ragged(str(error)) from None
        values, bad = {}, []
        for name, index in zip(names, indices, strict=True):
            cells = frame[index].fillna("").to_numpy()
            values[name] = self._numbers(cells)
            for row in np.flatnonzero(np.isnan(values[name])):
                bad.append(BadCell(int(row), name, cells[row][:40]))
        return Columns(len(frame), values, tuple(bad))

    def _column(self, name: str) -> int:
        if name not in self._index:
            raise unknown_column(name, self.names)
        return self._index[name]

    def _numbers(self, cells: NDArray[np.object_]) -> Floats:
        """Cells as floats; NaN where a cell is not a plain finite number."""
        import pandas as pd

        if self._decimal == ",":
            cells = np.array([cell.replace(",", ".") for cell in cells], dtype=object)
        numbers = pd.to_numeric(cells, errors="coerce").astype(np.float64)
        return np.where(np.isfinite(numbers), numbers, np.nan)

    def _ragged(self, error: str) -> DataError:
        found = re.search(r"Expected (\d+) fields in line (\d+), saw (\d+)", error)
        if not found:
            return DataError(f"{self._path} is not a table: {error.strip().splitlines()[0]}")
        line = int(found[2]) + self._header_lines
        return DataError(
            f"{self._path}: line {line} has {found[3]} cells where the first data line has "
            f"{self._width}: repair that line, or give --separator"
        )


def _decode(path: Path) -> str:
    """The file's text with one kind of line end. Latin-1 where it is not UTF."""
    data = read_file(path, DataError, MAX_BYTES, "a table")
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    if not data.strip():
        raise DataError(f"{path} is empty")
    if encoding == "utf-8-sig" and b"\0" in data:
        raise DataError(f"{path} is a binary file, not a text table: import reads CSV and MAT")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _head(text: str, lines: int) -> list[str]:
    stream = io.StringIO(text)
    return [line.rstrip("\n") for _, line in zip(range(lines), stream, strict=False)]


def _is_number(cell: str, decimal: str) -> bool:
    return bool(_NUMBER.match(cell.replace(",", ".") if decimal == "," else cell))


def _find_separator(lines: list[str], decimal: str | None) -> str:
    """The separator that cuts most lines into the same number of numeric cells."""
    best, score = "", 0
    for separator in (*_SEPARATORS, " "):
        if separator == decimal:
            continue
        rows = [line.split(separator) if separator != " " else line.split() for line in lines]
        widths = [
            len(row)
            for row in rows
            if len(row) > 1
            and any(cell.strip() for cell in row)
            and all(_is_number(c, ",") or _MISSING.match(c) for c in row)
        ]
        same = max((widths.count(width) for width in set(widths)), default=0)
        if same > score:
            best, score = separator, same
    return best or ","


def _find_decimal(lines: list[str], separator: str) -> str:
    """A comma inside cells that read as numbers with it is a decimal comma."""
    if separator == ",":
        return "."
    cells = [cell.strip() for line in lines for cell in re.split(re.escape(separator), line)]
    commas = sum(bool(re.fullmatch(r"[+-]?\d*,\d+([eE][+-]?\d+)?", cell)) for cell in cells)
    points = sum(bool(re.fullmatch(r"[+-]?\d*\.\d+([eE][+-]?\d+)?", cell)) for cell in cells)
    return "," if commas > points else "."
