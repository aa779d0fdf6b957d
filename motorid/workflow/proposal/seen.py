"""The columns of a table as they are: their readings, and what shows without their names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import Columns, Described, Source
from motorid.capture.continued_stamps import stale
from motorid.capture.formats import source_of
from motorid.capture.table_options import TableOptions
from motorid.errors import DataError
from motorid.limits import LOOK
from motorid.workflow.proposal.naming import Meaning, meaning

Floats = NDArray[np.float64]
FEWEST = 8  # columns that are looked at, however long
EVEN = 0.25  # relative spread of steps between rows that are all one period


@dataclass(frozen=True)
class Seen:
    """``values`` (rows,), NaN in cells without a number; ``unread``: why there are none."""

    described: Described
    values: Floats
    unread: str = ""

    @property
    def name(self) -> str:
        return self.described.name

    @cached_property
    def meaning(self) -> Meaning:
        return meaning(self.described)

    @cached_property
    def finite(self) -> Floats:
        return self.values[np.isfinite(self.values)]

    @cached_property
    def whole(self) -> bool:
        """Every reading is a whole number."""
        return bool(len(self.finite)) and bool(np.all(self.finite == np.rint(self.finite)))

    @cached_property
    def levels(self) -> int:
        """Different readings, of the first 10,000."""
        return len(np.unique(self.finite[:10_000]))

    @cached_property
    def steps(self) -> Floats:
        """Differences between readings that follow one another."""
        return np.diff(self.finite)

    @property
    def ascending(self) -> bool:
        """Nearly all readings are at least the one before, and the last is above the first; or all
        advance behind stale stamps at the start.
        """
        if stale(self.finite):
            return True
        if len(self.finite) < 2 or not self.finite[-1] > self.finite[0]:
            return False
        return bool(np.mean(self.steps >= 0.0) > 0.98 and np.mean(self.steps > 0.0) > 0.3)

    @cached_property
    def period(self) -> float:
        """The usual step; 0 where there is none."""
        return float(np.median(self.steps)) if len(self.steps) else 0.0

    @property
    def even(self) -> bool:
        """Steps are mostly one period."""
        usual = self.period
        return usual > 0.0 and bool(np.mean(np.abs(self.steps - usual) < EVEN * usual) > 0.7)

    @property
    def counts_rows(self) -> bool:
        """Each reading is one more than that before: it may number the rows."""
        return bool(len(self.steps)) and bool(np.all(self.steps == 1.0))


@dataclass(frozen=True)
class Table:
    """A file that was looked at. ``more``: columns beyond those that a look reads."""

    path: Path
    source: Source
    columns: tuple[Seen, ...]
    rows: int
    more: int = 0

    def named(self, name: str) -> Seen | None:
        """The column that any of its names leads to."""
        exact = [one for one in self.columns if one.name == name]
        found = exact or [one for one in self.columns if name in one.described.said]
        return found[0] if found else None


def look(path: Path, chosen: TableOptions) -> Table:
    """Reads the columns of a file, as many as a look may. Raises DataError, UsageError."""
    source = source_of(path, chosen)
    most = max(FEWEST, (LOOK.numbers or 0) // max(1, source.rows))
    described = source.described[: min(LOOK.columns or 0, most)]
    read = _read_all(source, described)
    lengths = Counter(len(values) for values, why in read if not why)
    if not lengths:
        said = next((why for _, why in read if why), "")
        also = f"; {source.elsewhere}" if source.elsewhere else ""
        raise DataError(said or f"{path} holds no column of numbers{also}")
    rows = max(lengths, key=lambda length: (lengths[length], length))
    columns = []
    for one, (values, why) in zip(described, read, strict=True):
        if not why and len(values) != rows:
            why = f"has {len(values):,} readings where others have {rows:,}"
        columns.append(Seen(one, values if not why else np.full(rows, np.nan), why))
    return Table(path, source, tuple(columns), rows, len(source.described) - len(described))


def _read_all(source: Source, described: Sequence[Described]) -> list[tuple[Floats, str]]:
    """Readings of each column, or why there are none."""
    try:
        found = source.read([one.name for one in described])
        return [_readings(found, one.name) for one in described]
    except DataError:
        return [_read_one(source, d.name) for d in described]  # one of them cannot be read


def _read_one(source: Source, name: str) -> tuple[Floats, str]:
    try:
        return _readings(source.read([name]), name)
    except DataError as error:
        return np.zeros(0), str(error)


def _readings(found: Columns, name: str) -> tuple[Floats, str]:
    values = found.values[name]
    if np.isfinite(values).any():
        return values, ""
    text = next((cell.text for cell in found.bad if cell.column == name), "")
    return values, f"holds no number, but {text!r}" if text else "is empty"
