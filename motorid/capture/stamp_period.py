"""The period and the starts that bounds on every sample's moment allow.

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

Floats = NDArray[np.float64]
Places = NDArray[np.int64]

SAME = 2e-5  # of a period: stamps so close to a grid are on it, whatever they were rounded to
ROUNDS = 60


@dataclass(frozen=True)
class Grid:
    """Stamps on a grid: ``places`` (n,) in periods from the first, in the stamps' own unit.

    Places are whole numbers but for a part of the record that began anew after a pause.
    ``start`` is the moment of place 0 after the first stamp. ``resolution`` is the largest step
    that stamps were rounded to; ``uncertainty`` the relative standard uncertainty of the period.
    """

    period: float
    start: float
    places: Floats
    resolution: float
    uncertainty: float

    @property
    def coarse(self) -> float:
        """The resolution in periods."""
        return self.resolution / self.period


def laid(
    stamps: Floats, count: Places, resolution: Floats, pauses: Sequence[int] | NDArray[np.intp]
) -> Grid | None:
    """The grid of ``stamps`` (n,) at whole places ``count`` (n,), rounded to ``resolution`` (n,).

    It has one period, and its parts from each of ``pauses`` on begin where they like. None: the
    rounding allows no such grid.
    """
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
        usual = float(np.median(np.diff(stamps)))  # 0: the rounding is more than a period
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
        return Grid(
            period, float(start[0]), places, step, (most - least) / (math.sqrt(12) * period)
        )
