"""The uniform sample period behind time stamps that were rounded.

A logger that samples every 169.49 µs and writes stamps to .1 µs shows periods of 169.4 and 169.5
µs. The motor saw neither. Where one start and one period explain every stamp within half the step that
it was rounded to, the samples lie on that grid. Where none does, the stamps are what they say.

A period T is possible if w(T) >= 0, w being the slack that the best start leaves. w is concave and
straight between corners, so Newton's method finds both its zeros from outside in a few steps. The
middle between them is the period, and half their distance bounds its error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.stamp_resolution import resolutions

Floats = NDArray[np.float64]
Places = NDArray[np.int64]

FEWEST = 16  # stamps that say what their grid is
UNIT = 1.5  # usual periods: a step below is one sample's
PAUSE = 2.5  # periods: after one that is longer a logger may begin a new grid
SAME = 2e-5  # of a period: stamps so close to a grid are on it, whatever they were rounded to
ROUNDS = 60
CLEAR = 0.5  # of a period: stamps rounded to more do not say how many samples lie between two
OFTEN, ENOUGH = 0.05, 8  # share and number of double steps that are a rounding and no losses
ALIKE = 0.5  # of the rows that repeat a stamp: so many with the same readings are written twice


@dataclass(frozen=True)
class Grid:
    """Stamps on a grid: ``places`` (n,) in periods from the first, in the stamps' own unit.

    Places are whole numbers but for a part of the record that began anew after a pause.
    ``resolution`` is the largest step that stamps were rounded to; ``uncertainty`` the relative
    standard uncertainty of the period.
    """

    period: float
    places: Floats
    resolution: float
    uncertainty: float

    @property
    def coarse(self) -> float:
        """The resolution in periods."""
        return self.resolution / self.period


def grid_of(stamps: Floats, rows: Floats) -> Grid | None:
    """The uniform grid that explains ``stamps`` (n,), which must not decrease; None: none does.

    ``rows`` (n,) are their places in the file, which count the samples where stamps cannot.
    """
    steps = np.diff(stamps)
    if len(stamps) < FEWEST or not stamps[-1] > stamps[0]:
        return None
    unit = steps[steps <= UNIT * np.median(steps)]
    for resolution in resolutions(stamps, unit):
        for count, most in ((_by_steps(stamps), CLEAR), (_by_rows(rows), np.inf)):
            found = _grid(stamps, count, resolution) if count is not None else None
            if found is not None and found.coarse <= most:
                return found
    return None


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
        count = np.r_[0, np.cumsum(np.rint(steps / period))].astype(np.int64)
        if np.diff(count).min() < 1:
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
    whole = _parts(stamps, count, resolution, [])
    pauses = np.flatnonzero(np.diff(count) > PAUSE) + 1
    if whole is not None or not len(pauses):
        return whole
    parts = _parts(stamps, count, resolution, pauses)
    if parts is None:
        return None
    again = np.rint(parts.places).astype(np.int64)  # by a period that is now known well
    return _parts(stamps, again, resolution, []) or parts


def _parts(
    stamps: Floats, count: Places, resolution: Floats, pauses: Sequence[int] | NDArray[np.intp]
) -> Grid | None:
    """The grid of one period whose parts after ``pauses`` begin where they like."""
    bounds = _Bounds.of(stamps, count, resolution, np.r_[0, pauses].astype(np.intp))
    periods = bounds.periods()
    return bounds.grid(*periods) if periods is not None and periods[0] > 0 else None


@dataclass(frozen=True)
class _Bounds:
    """Where each stamp's moment lies: ``low`` to ``high`` (n,); parts begin at ``starts`` (p,)."""

    count: Places
    low: Floats
    high: Floats
    starts: NDArray[np.intp]

    @classmethod
    def of(
        cls, stamps: Floats, count: Places, resolution: Floats, starts: NDArray[np.intp]
    ) -> _Bounds:
        own = np.zeros(len(stamps), dtype=np.int64)  # counted from each part's own start
        own[starts] = np.diff(count[starts], prepend=0)
        within = count - np.cumsum(own)
        first = stamps - stamps[0]
        usual = float(np.median(np.diff(stamps))) or first[-1] / float(count[-1])
        half = np.maximum(resolution, SAME * usual) / 2
        return cls(within, first - half, first + half, starts)

    def start(self, period: float) -> tuple[Floats, Floats]:
        """Earliest and latest moment (p,) at which each part can start; crossed: it cannot."""
        moved = self.count * period
        earliest = np.maximum.reduceat(self.low - moved, self.starts)
        return earliest, np.minimum.reduceat(self.high - moved, self.starts)

    def slack(self, period: float) -> tuple[float, float]:
        """w and its slope, of the part that leaves the least."""
        earliest, latest = self.start(period)
        part = int(np.argmin(latest - earliest))
        stops = np.r_[self.starts[1:], len(self.count)]
        own = slice(int(self.starts[part]), int(stops[part]))
        moved = self.count[own] * period
        i, j = int(np.argmin(self.high[own] - moved)), int(np.argmax(self.low[own] - moved))
        value = float(latest[part] - earliest[part])
        return value, float(self.count[own][j] - self.count[own][i])

    def periods(self) -> tuple[float, float] | None:
        """The shortest and the longest possible period, or None where there is none."""
        longest = int(self.count.max())
        if not longest:
            return None
        sizes = np.diff(np.r_[self.starts, len(self.count)])
        n, t = (
            x - np.repeat(np.add.reduceat(x, self.starts) / sizes, sizes)
            for x in (self.count.astype(np.float64), (self.low + self.high) / 2)
        )
        usual = float(n @ t / (n @ n))
        reach = 4 * float(np.max(self.high - self.low))
        if not usual > 0 or self.slack(usual)[0] < -reach:
            return None
        beyond = 2 * reach / longest
        least, most = self._edge(usual - beyond), self._edge(usual + beyond)
        return None if least is None or most is None else (min(least, most), max(least, most))

    def _edge(self, period: float) -> float | None:
        """Where w becomes 0, from a period outside that; None: w turns before.

        The tangents of a concave function lie above it: each is 0 no farther than w is.
        """
        value, slope = self.slack(period)
        inwards = np.sign(slope)
        for _ in range(ROUNDS):
            if value >= 0:
                return period
            if slope * inwards <= 0:
                return None
            before, period = period, period - value / slope
            if period == before:
                return period
            value, slope = self.slack(period)
        return None

    def grid(self, least: float, most: float) -> Grid:
        """The samples on the grid of the middle of these periods."""
        period = (least + most) / 2
        earliest, latest = self.start(period)
        sizes = np.diff(np.r_[self.starts, len(self.count)])
        start = (earliest + latest) / 2
        places = self.count + np.repeat((start - start[0]) / period, sizes)
        step = float(np.max(self.high - self.low))
        return Grid(period, places, step, (most - least) / (math.sqrt(12) * period))
