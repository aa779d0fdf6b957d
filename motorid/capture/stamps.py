"""From a file's time column to the ticks of a capture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture import table_checks as checks
from motorid.capture.columns import Source
from motorid.capture.mapping import ROW
from motorid.capture.stamp_grid import grid_of, regular, written_twice
from motorid.capture.stamp_period import Grid

Floats = NDArray[np.float64]
Ticks = NDArray[np.int64]

CLOCK_HZ = 1e9  # ticks of stamps that are kept: whole nanoseconds


@dataclass(frozen=True)
class Clock:
    """``ticks`` (n,) of a clock of ``hz``, whose relative standard uncertainty is ``uncertainty``.

    ``ahead`` (rows,): rows that are kept; None: all of them. ``grid``: what the stamps were
    rounded from; None: they are kept as they are.
    """

    ticks: Ticks
    hz: float = CLOCK_HZ
    uncertainty: float = 0.0
    ahead: NDArray[np.bool_] | None = None
    grid: Grid | None = None


def clock_of(
    path: Path,
    source: Source,
    stamps: Floats,
    unit_s: float,
    values: Mapping[str, Floats],
    drop_bad: bool,
    notes: list[str],
) -> Clock:
    """The clock of ``stamps`` (rows,) in units of ``unit_s``; ``values`` are the other columns.

    Raises DataError where stamps do not advance and no uniform period explains why, unless
    ``drop_bad``.
    """
    ticks = _nanoseconds(stamps, unit_s)
    rows = values[ROW]
    if _repeats(ticks) and not written_twice(stamps, [v for n, v in values.items() if n != ROW]):
        grid = grid_of(stamps, rows)
        if grid is not None:
            return _on_grid(grid, unit_s, None, notes)
    ahead = checks.stamps_that_advance(path, source, ticks, rows, drop_bad, notes)
    kept = None if ahead.all() else ahead
    if kept is not None:
        stamps, ticks, rows = stamps[kept], ticks[kept], rows[kept]
    if len(ticks) < 2 or regular(np.diff(ticks)):
        return Clock(ticks, ahead=kept)
    grid = grid_of(stamps, rows)
    return Clock(ticks, ahead=kept) if grid is None else _on_grid(grid, unit_s, kept, notes)


def _nanoseconds(stamps: Floats, unit_s: float) -> Ticks:
    since = (stamps * unit_s) - stamps[0] * unit_s
    since *= CLOCK_HZ
    return np.asarray(np.rint(since, out=since).astype(np.int64))


def _repeats(ticks: Ticks) -> bool:
    """Some stamps repeat the one before, and none steps back."""
    return len(ticks) > 1 and int(np.diff(ticks).min()) == 0


def _on_grid(grid: Grid, unit_s: float, ahead: NDArray[np.bool_] | None, notes: list[str]) -> Clock:
    """A clock of about a nanosecond, of whose ticks the period is a whole number."""
    period_s = grid.period * unit_s
    whole = max(1, round(period_s * CLOCK_HZ))
    ticks = np.rint(grid.places * whole).astype(np.int64)
    if grid.coarse > checks.IRREGULAR:
        notes.append(
            f"stamps are rounded to {grid.resolution * unit_s:.3g} s: the uniform period "
            f"{period_s:.8g} s explains them all, and replaces them"
        )
    return Clock(ticks, whole / period_s, grid.uncertainty, ahead, grid)
