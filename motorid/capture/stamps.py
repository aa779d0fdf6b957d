"""From a file's time column to the ticks of a capture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture import table_checks as checks
from motorid.capture.columns import Source
from motorid.capture.continued_stamps import continued, single
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

    A counter that wraps, a logger that begins anew and rows that are copies of the one before
    are put right. Raises DataError where stamps do not advance all the same and no uniform period
    explains why, unless ``drop_bad``.
    """
    stamps = continued(stamps, unit_s, notes)
    ticks, rows = _nanoseconds(stamps, unit_s), values[ROW]
    if _repeats(ticks):
        readings = [v for n, v in values.items() if n != ROW]
        once = single(stamps, readings)
        if np.all(np.diff(ticks[once]) > 0):
            notes.append(f"{int((~once).sum())} rows that copy the row before them left out")
            found = _advancing(stamps[once], ticks[once], rows[once], unit_s, notes)
            return replace(found, ahead=once)
        if not written_twice(stamps, readings):
            grid = grid_of(stamps, rows)
            if grid is not None:
                return _on_grid(grid, unit_s, notes)
    ahead = checks.stamps_that_advance(path, source, ticks, rows, drop_bad, notes)
    if ahead.all():
        return _advancing(stamps, ticks, rows, unit_s, notes)
    found = _advancing(stamps[ahead], ticks[ahead], rows[ahead], unit_s, notes)
    return replace(found, ahead=ahead)


def _advancing(
    stamps: Floats, ticks: Ticks, rows: Floats, unit_s: float, notes: list[str]
) -> Clock:
    """The clock of stamps each of which lies after the one before."""
    if len(ticks) < 2 or regular(np.diff(ticks)):
        return Clock(ticks)
    grid = grid_of(stamps, rows)
    return Clock(ticks) if grid is None else _on_grid(grid, unit_s, notes)


def _nanoseconds(stamps: Floats, unit_s: float) -> Ticks:
    since = (stamps * unit_s) - stamps[0] * unit_s
    since *= CLOCK_HZ
    return np.asarray(np.rint(since, out=since).astype(np.int64))


def _repeats(ticks: Ticks) -> bool:
    """Some stamps repeat the one before, and none steps back."""
    return len(ticks) > 1 and int(np.diff(ticks).min()) == 0


def _on_grid(grid: Grid, unit_s: float, notes: list[str]) -> Clock:
    """A clock of about a nanosecond, of whose ticks the period is a whole number."""
    period_s = grid.period * unit_s
    whole = max(1, round(period_s * CLOCK_HZ))
    ticks = np.rint(grid.places * whole).astype(np.int64)
    if grid.coarse > checks.IRREGULAR:
        notes.append(
            f"stamps are rounded to {grid.resolution * unit_s:.3g} s: the uniform period "
            f"{period_s:.8g} s explains them all, and replaces them"
        )
    return Clock(ticks, whole / period_s, grid.uncertainty, grid=grid)
