"""A foreign file, read: its columns as numbers, and what its header says of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.errors import UsageError, nearest

Floats = NDArray[np.float64]
_SHOWN = 30


@dataclass(frozen=True)
class BadCell:
    """A cell that holds no number."""

    row: int  # 0-based, of the data
    column: str
    text: str  # what it holds; "" for an empty cell


@dataclass(frozen=True)
class Columns:
    """Columns that were asked for: shape (rows,) each, or (1,) for a constant; NaN in bad cells."""

    rows: int
    values: Mapping[str, Floats]
    bad: tuple[BadCell, ...] = ()  # the first of each column that has any


@dataclass(frozen=True)
class Described:
    """A column as its file presents it: a name that leads to it, and what its header says."""

    name: str
    said: tuple[str, ...] = ()  # every cell of its header, from the top; none where it has none
    unit: str = ""  # of the header; "" where it says none


class Source(Protocol):
    """A file with named columns."""

    names: Sequence[str]  # every name that a column goes by
    described: Sequence[Described]  # each column of readings once, as the file orders them
    constants: Mapping[str, float]  # numbers with names that stand beside the readings
    rows: int  # at most
    header_units: Mapping[str, str]  # what the file itself says of a column's unit, by name
    elsewhere: str  # what it holds that no name leads to, as a clause; empty: nothing
    layout: str  # how the file was read, for the record: "';'-separated, 3 header lines"

    def read(self, names: Sequence[str]) -> Columns:
        """Those columns. Raises DataError."""

    def place(self, row: int) -> str:
        """Where a row stands in the file, for a person: "line 17"."""


def unknown_column(name: str, columns: Sequence[str]) -> UsageError:
    """The error for a name that the file does not have."""
    shown = ", ".join(columns[:_SHOWN]) + (", ..." if len(columns) > _SHOWN else "")
    return UsageError(f"the file has no column {name!r}{nearest(name, columns)}; it has: {shown}")
