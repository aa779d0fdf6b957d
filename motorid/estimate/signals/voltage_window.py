"""Through which window a voltage channel sees: an average, a delay, and a filter before both.

A filter of first order forgets exponentially, so that the first readings after a command show a
little of the voltage before it. How much is known, and so is that voltage: it is taken out. The
model's current is seen through the same window, so that a source's line joins like with like.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Channel
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.motor.reading import Output, Quantity

Floats = NDArray[np.float64]

EDGE = 1e-3  # of a period, by which a window may reach over a step
FADED = 0.05  # of a reading may be of the command before: more would rest on the filter's part
MOST = 0.5  # the same where a part is so short that half of its readings show more


@dataclass(frozen=True)
class Window:
    """Of readings one each ``period_s``: ``aperture_s`` wide (0: an instant), ending ``delay_s``
    before its tick, of which ``filter_s`` is a filter's.
    """

    period_s: float
    aperture_s: float = 0.0
    delay_s: float = 0.0
    filter_s: float = 0.0

    @classmethod
    def of(cls, channel: Channel, period_s: float) -> Window:
        """The channel's, as declared."""
        late = channel.delay_s
        return cls(period_s, channel.window_s, late, min(channel.filter_s, late))

    @property
    def lag(self) -> int:
        """Whole samples by which the readings come late."""
        return math.floor(self.delay_s / self.period_s + EDGE)

    @property
    def late_s(self) -> float:
        """What is left of the delay beyond whole samples."""
        return max(self.delay_s - self.lag * self.period_s, 0.0)

    def readings(self, grid: Floats, timeline: Timeline) -> Floats:
        """Readings (count,) at the intervals that they describe, each of its own command alone.

        NaN where none came, or where one shows a mixture that is not to be told apart.
        """
        early = self._put_back(grid, np.full(self.lag, np.nan))
        parts, reaches_over = timeline.parts, EDGE * self.period_s
        for part in parts:
            first = early[part.slice]
            first[self._begins(first) < -reaches_over] = np.nan
        if not self.filter_s:
            return early
        cleared, foresees = self._cleared(early, parts, np.nan), self.foresees
        for part in parts[:-1]:
            cleared[max(part.stop - foresees, part.start) : part.stop] = np.nan
        return cleared

    @property
    def outputs(self) -> list[Output]:
        """What the model's current is to be read by, for ``current``."""
        wide, late = self.aperture_s or self.period_s, self.delay_s - self.filter_s
        return [Output(Quantity.CURRENT, wide, late, filter_s=self.filter_s)]

    def current(self, rows: Floats, mean: Floats, timeline: Timeline) -> Floats:
        """The current (count,) over the windows of ``readings``, from the rows of ``outputs``.

        ``mean`` (count,) is that over the intervals, and stands where no reading came.
        """
        seen = self._put_back(rows[0], mean[len(mean) - self.lag :])
        return self._cleared(seen, timeline.parts) if self.filter_s else seen

    @property
    def foresees(self) -> int:
        """How many of the last readings of a part know of the next command already."""
        before = -self.period_s * np.arange(self.lag + 1, dtype=np.float64)
        return int(np.sum(self.older(before) < 1.0 - EDGE)) if self.filter_s else 0

    def half_shows(self, count: int) -> float:
        """Share of the command before in half of the readings, at least, of a part of ``count``
        intervals; 1: none is of its own command.
        """
        own = count - self.foresees
        if own <= 0:
            return 1.0
        return float(self.older(np.array([(own // 2 + 1) * self.period_s]))[0])

    def older(self, since_s: Floats) -> Floats:
        """Share of a reading that shows what was before a command, (n,).

        ``since_s`` (n,): how long after the command its interval ended.
        """
        tau, late = self.filter_s, self.late_s
        end = since_s - (late - tau)
        begin = end - self.aperture_s
        if not self.aperture_s:
            return np.asarray(np.exp(-np.maximum(end, 0.0) / tau))
        inside = np.minimum(end, 0.0) - np.minimum(begin, 0.0)
        tail = np.exp(-np.maximum(begin, 0.0) / tau) - np.exp(-np.maximum(end, 0.0) / tau)
        return np.asarray((inside + tau * tail) / self.aperture_s)

    def _put_back(self, grid: Floats, last: Floats) -> Floats:
        return np.concatenate([grid[self.lag :], last])

    def _begins(self, part: Floats) -> Floats:
        """When (s) the windows of a part's readings begin after its command, the filter a delay."""
        ended = (np.arange(len(part)) + 1 + self.lag) * self.period_s
        return np.asarray(ended - self.delay_s - self.aperture_s)

    def _cleared(self, early: Floats, parts: Sequence[Part], mixed: float | None = None) -> Floats:
        """Without what the first readings of a part show of the part before; ``mixed`` stands for
        those that show too much of it, None: they stay.

        All that a filter knows of what was before a command is where it stood then: the last
        reading that does not know of that command shows it.
        """
        cleared, foresees = early.copy(), self.foresees
        for earlier, part in pairwise(parts):
            here = early[part.slice]
            share = self.older(self.period_s * np.arange(1, len(here) + 1, dtype=np.float64))
            before = early[earlier.start : max(earlier.stop - foresees, earlier.start)]
            known = before[np.isfinite(before)]
            half = self.half_shows(len(here))
            allowed = half if FADED < half <= MOST else FADED
            faded = share <= (allowed if len(known) else EDGE)
            was = known[-1] if len(known) else 0.0
            alone = (here - share * was) / np.where(faded, 1.0 - share, 1.0)
            cleared[part.slice] = np.where(faded, alone, here if mixed is None else mixed)
        return cleared
