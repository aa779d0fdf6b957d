"""The uniform sample period behind time stamps that were rounded.

A logger that samples every 169.49 µs and writes stamps to .1 µs shows periods of 169.4 and 169.5.
The motor saw neither. Where one start and one period explain the stamps within half the step that
they were rounded to, the samples lie on that grid; a few that were late keep their own moments.
Where nothing explains nine in ten, the stamps are what they say.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.stamp_period import SAME, Floats, Grid, Places, laid
from motorid.capture.stamp_resolution import resolutions

FEWEST = 16  # stamps that say what their grid is
UNIT = 1.55  # usual periods: a step below is one sample's, be it 3 of a timer where 2 are usual
PAUSE = 2.5  # periods: after one that is longer a logger may begin a new grid
ROUNDS = 60
CLEAR = 0.5  # of a period: stamps rounded to more do not say how many samples lie between two
MOST = 0.9  # share of the stamps on a grid that others miss
APART = 1e-3  # periods, at least, between two samples
FINE = 0.1  # of a period: stamps rounded to more do not say which samples were late
LOOSE = 0.02  # of a period, beyond the rounding: a step that is still one period
TRIMS, SPREAD = 20, 4.0  # rounds; times the median distance from a line that is still near it
CORE = 0.98  # of half a rounding step: so near a line are the stamps that lay the grid
AGAIN = 1.25  # of half a rounding step: so near are those that lie on a grid that others laid
OFTEN, ENOUGH = 0.05, 8  # share and number of double steps that are a rounding and no losses
ALIKE = 0.5  # of the rows that repeat a stamp: so many with the same readings are written twice


def grid_of(stamps: Floats, rows: Floats) -> Grid | None:
    """The uniform grid that explains ``stamps`` (n,), which must not decrease; None: none does.

    ``rows`` (n,) are their places in the file, which count the samples where stamps cannot.
    """
    steps = np.diff(stamps)
    if len(stamps) < FEWEST or not stamps[-1] > stamps[0]:
        return None
    unit = steps[steps <= UNIT * np.median(steps)]
    written, *others = resolutions(stamps, unit)
    by_steps = _by_steps(stamps)
    for resolution in (written, *others):
        for count, most in ((by_steps, CLEAR), (_by_rows(rows), math.inf)):
            found = _grid(stamps, count, resolution) if count is not None else None
            if found is not None and found.coarse <= most:
                return found
    return _of_most(stamps, written)


def regular(steps: Places) -> bool:
    """Differences (n,) of stamps in ticks are a uniform grid as they stand.

    Where every step is one tick or two, and two often, a longer period was rounded.
    """
    least = int(steps.min())
    if least <= 0 or np.any(steps % least):
        return False
    double = int(np.sum(steps == 2 * least))
    rounded = steps.max() == 2 * least and double >= max(ENOUGH, OFTEN * len(steps))
    return not rounded


def written_twice(stamps: Floats, readings: Sequence[Floats]) -> bool:
    """Rows that repeat a stamp mostly repeat all readings, each (n,), as well."""
    again = stamps[1:] == stamps[:-1]
    same = again.copy()
    for values in readings:
        same &= (values[1:] == values[:-1]) | np.isnan(values[1:])
    return float(same.sum()) > ALIKE * float(again.sum())


def _by_rows(rows: Floats) -> Places:
    """Whole places (n,) where the file lost no sample."""
    return np.asarray(rows - rows[0], dtype=np.int64)


def _by_steps(stamps: Floats) -> Places | None:
    """Whole places (n,) by the steps between stamps, so that lost samples leave theirs empty."""
    steps = np.diff(stamps)
    if not steps.min() > 0:
        return None
    period = float(np.mean(steps[steps <= UNIT * np.median(steps)]))
    for _ in range(ROUNDS):
        count: Places = np.r_[0, np.cumsum(np.rint(steps / period))].astype(np.int64)
        if 2 * count[-1] < len(count):
            return None
        before, period = period, _slope(stamps, count)
        if abs(period - before) * float(count[-1]) <= SAME * period:
            return count
    return None


def _slope(stamps: Floats, count: Places) -> float:
    """Least squares: the period."""
    n = count - count.mean()
    return float(n @ (stamps - stamps.mean()) / (n @ n))


def _grid(stamps: Floats, count: Places, resolution: Floats) -> Grid | None:
    """The grid at these places, whole or in parts between pauses, if the rounding allows one."""
    if np.diff(count).min() < 1:
        return None
    whole = laid(stamps, count, resolution, [])
    pauses = np.flatnonzero(np.diff(count) > PAUSE) + 1
    if whole is not None or not len(pauses):
        return whole
    parts = laid(stamps, count, resolution, pauses)
    if parts is None:
        return None
    again = np.rint(parts.places).astype(np.int64)  # by a period that is now known well
    return laid(stamps, again, resolution, []) or parts


def _of_most(stamps: Floats, resolution: Floats) -> Grid | None:
    """The grid of nine stamps in ten; the others keep their own moments, but for the first.

    The first sample is where a record's time begins, and is taken as on the grid.
    """
    steps = np.diff(stamps)
    usual = float(np.median(steps))
    plain = np.abs(steps - usual) <= 1.01 * float(resolution.max()) + LOOSE * usual
    beside = np.r_[plain, False] | np.r_[False, plain]
    if np.mean(beside) < MOST or resolution.max() > FINE * usual:
        return None
    kept, written = stamps[beside], resolution[beside]
    core, count = _core(kept, written, float(np.mean(steps[plain])))
    if core.sum() < FEWEST or np.diff(count[core]).min() < 1:
        return None
    found = laid(kept[core], count[core], written[core], [])
    if found is None:
        return None
    places = (stamps - kept[core][0] - found.start) / found.period
    whole = np.rint(places)
    on = np.abs(places - whole) <= AGAIN * np.maximum(resolution / found.period, SAME) / 2
    on[0] = True
    if np.mean(on) < MOST:
        return None
    places[on] = whole[on]
    return replace(found, places=places - places[0]) if np.diff(places).min() > APART else None


def _core(stamps: Floats, resolution: Floats, period: float) -> tuple[NDArray[np.bool_], Places]:
    """Stamps (n,) within their rounding of the line through most, and whole places (n,) of all."""
    core = np.ones(len(stamps), dtype=bool)
    count = np.zeros(len(stamps), dtype=np.int64)
    for _ in range(TRIMS):
        if core.sum() < FEWEST:
            break
        count = np.r_[0, np.cumsum(np.rint(np.diff(stamps) / period))].astype(np.int64)
        n, t = count - count[core].mean(), stamps - stamps[core].mean()
        period = float(n[core] @ t[core] / (n[core] @ n[core]))
        left = t - n * period
        left = np.abs(left - np.median(left[core]))
        half = np.maximum(resolution, SAME * period) / 2
        core, before = left <= np.maximum(half, SPREAD * float(np.median(left))), core
        if np.array_equal(before, core):
            return left <= CORE * half, count
    return np.zeros(len(stamps), dtype=bool), count
