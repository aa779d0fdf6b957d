"""Columns of numbers out of the lines of a text table, piece by piece."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import BadCell, Columns
from motorid.capture.csv_marks import Ambiguous, Marks, looks_marked
from motorid.capture.record_lines import Moment, moment

Floats = NDArray[np.float64]
PIECE = 1 << 16  # lines that are parsed at a time, at most
CELLS = 1 << 21  # and cells


class Lines(Protocol):
    """What the parser reads from."""

    def read(self, count: int = -1, /) -> str:
        """The next characters."""

    def __iter__(self) -> Iterator[str]: ...


class NotPlainError(Exception):
    """Some cell is not a plain finite number: each has to be looked at."""


class MarkedError(Exception):
    """A cell that is a number only with other marks than the table's."""

    def __init__(self, cell: BadCell, question: str) -> None:
        super().__init__(question)
        self.cell, self.question = cell, question


class Parser:
    """A table of ``width`` columns. Its errors are those of pandas.

    ``moments``: columns of dates and times, which become seconds since the first.
    """

    def __init__(
        self, separator: str, marks: Marks, width: int, moments: Collection[int] = ()
    ) -> None:
        self._separator, self._marks, self._width = separator, marks, width
        self._moments = moments

    def plain(self, lines: Lines, wanted: Mapping[str, int], rows: int) -> Columns:
        """Columns by name, of no more than ``rows`` rows, where every cell is a number.

        Raises NotPlainError where one is not.
        """
        if self._marks.thousands or any(index in self._moments for index in wanted.values()):
            raise NotPlainError
        values = {name: np.empty(rows) for name in wanted}
        types = {n: np.float64 if n in wanted.values() else object for n in range(self._width)}
        done = 0
        try:
            for piece in self._pieces(
                lines, dtype=types, na_filter=False, decimal=self._marks.decimal
            ):
                for name, index in wanted.items():
                    numbers = piece[index].to_numpy()
                    if numbers.dtype != np.float64 or not np.isfinite(numbers).all():
                        raise NotPlainError
                    values[name][done : done + len(piece)] = numbers
                done += len(piece)
        except ValueError:  # of which the parser's errors are a kind
            raise NotPlainError from None
        return Columns(done, {name: column[:done] for name, column in values.items()})

    def careful(self, lines: Lines, wanted: Mapping[str, int], rows: int) -> Columns:
        """The same where some cells hold no number: NaN, and the first of each column.

        Raises MarkedError for one that is a number by other marks: to leave it out would leave out
        what is large.
        """
        values = {name: np.empty(rows) for name in wanted}
        bad: dict[str, BadCell] = {}
        firsts: dict[int, Moment] = {}
        done = 0
        for piece in self._pieces(lines, dtype=object, keep_default_na=False):
            for name, index in wanted.items():
                cells = piece[index].fillna("").to_numpy()
                if index in self._moments:
                    numbers = _seconds(cells, index, firsts)
                else:
                    numbers = self._marks.numbers(cells)
                values[name][done : done + len(piece)] = numbers
                missing = np.isnan(numbers)
                for place in np.flatnonzero(missing):
                    if (text := cells[place].strip()) and looks_marked(text):
                        cell = BadCell(done + int(place), name, text)
                        raise MarkedError(cell, self._marks.question(text))
                if name not in bad and missing.any():
                    row = int(np.argmax(missing))
                    bad[name] = BadCell(done + row, name, str(cells[row])[:40])
            done += len(piece)
        found = {name: column[:done] for name, column in values.items()}
        return Columns(done, found, tuple(bad.values()))

    def _pieces(self, lines: Lines, **how: Any) -> Iterator[Any]:
        import pandas as pd

        source: Any = lines  # whatever has read and lines is enough for the parser
        with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):
            try:
                yield from pd.read_csv(
                    source,
                    sep=r"\s+" if self._separator == " " else self._separator,
                    header=None,
                    names=list(range(self._width)),
                    index_col=False,
                    skip_blank_lines=False,
                    on_bad_lines="error",
                    chunksize=min(PIECE, max(1, CELLS // self._width)),
                    **how,
                )
            except pd.errors.EmptyDataError:
                return

    def ambiguous(self, lines: Lines, column: Mapping[str, int]) -> Ambiguous:
        """Whether the decimal mark of that one column may group thousands."""
        ((name, index),) = column.items()
        found, done = Ambiguous(name, self._marks.decimal), 0
        for piece in self._pieces(lines, dtype=object, keep_default_na=False):
            found.look(piece[index].fillna("").to_numpy(), done)
            done += len(piece)
        return found


def _seconds(cells: Sequence[str], index: int, firsts: dict[int, Moment]) -> Floats:
    """Seconds since the first date and time of a column, which ``firsts`` keeps; NaN for others."""
    found = [moment(cell.strip()) for cell in cells]
    known = next((one for one in found if one is not None), None)
    first = firsts.setdefault(index, known) if known is not None else firsts.get(index)
    return np.array(
        [np.nan if one is None or first is None else one.since(first) for one in found], dtype=float
    )
