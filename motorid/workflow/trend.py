"""Where a trend's readings come from: the history, or a CSV file."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError, UsageError, nearest

if TYPE_CHECKING:
    from motorid.quality.history import Query

DAY_S = 86400.0


@dataclass(frozen=True)
class Series:
    """Readings (n,) in their order, ``days`` from the first; the limits last in force, if any."""

    values: NDArray[np.float64]
    days: NDArray[np.float64]
    unit: str = ""
    lower: float | None = None
    upper: float | None = None


def from_csv(path: Path, quantity: str) -> Series:
    """A column of a CSV file; a column ``time`` (ISO 8601) or else the row's number says when."""
    from motorid.quality.study_file import column, read_rows

    rows = read_rows(path)
    values = np.array(column(rows, quantity, str(path)))
    if "time" not in rows[0]:
        return Series(values, np.arange(float(len(values))))
    try:
        at = [datetime.fromisoformat(row["time"]).timestamp() for row in rows]
    except (ValueError, OverflowError, OSError) as error:
        raise DataError(f"{path}: a time cannot be read: {error}") from None
    return Series(values, (np.array(at) - at[0]) / DAY_S)


def from_history(where: str, quantity: str, query: Query, last: int | None = None) -> Series:
    """A quantity of the results that ``query`` chooses. Raises where the history has none."""
    from motorid.quality.history import open_history

    with open_history(where, create=False) as history:
        newest = history.series(quantity, query, last=1)
        names = [quantity] if newest else history.names()
        if quantity not in names:
            raise UsageError(f"{where} never measured {quantity!r}{nearest(quantity, names)}")
        if not newest:
            raise DataError(f"{where} has no such result with {quantity}: widen the query")
        at, values = history.arrays(quantity, query, last)
    days = (at - at[0]) / np.timedelta64(1, "D")
    return Series(values, days, newest[0].unit, newest[0].low, newest[0].high)
