"""The board's clock against the host's: a line through ticks and the times they were asked at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.errors import DataError

WRAP = 1 << 32
FEWEST = 10


@dataclass(frozen=True)
class Pair:
    """A tick count of the board, and the host's time (s) just before and after it was asked."""

    tick: int
    before_s: float
    after_s: float


@dataclass(frozen=True)
class Clock:
    """``rate``: true ticks a second over the nominal ones; ``uncertainty`` standard, relative."""

    rate: float
    uncertainty: float
    span_s: float
    pairs: int


def clock_of(pairs: Sequence[Pair], nominal_hz: float, host_uncertainty: float) -> Clock:
    """The clock's rate; ``host_uncertainty`` (standard, relative) is that of the host's clock.

    The quicker half of the round trips is used. Each way has a shortest time that does not change,
    so a trip that takes d longer than the shortest is off its middle by at most d/2: that, the one
    way at the one end and the other way at the other, bounds the slope beside its scatter. Raises
    DataError for fewer than ten pairs, or where the ticks do not increase.
    """
    trips = np.array([p.after_s - p.before_s for p in pairs])
    if len(pairs) < FEWEST:
        raise DataError(f"a clock needs {FEWEST} pairs of tick and time or more")
    middle = np.array([(p.before_s + p.after_s) / 2 for p in pairs])
    ticks = _unwrapped(np.array([p.tick for p in pairs], dtype=np.int64), middle * nominal_hz)
    kept = trips <= np.sort(trips)[max(len(trips) // 2, FEWEST) - 1]
    times = middle[kept]
    ticks = ticks[kept] / nominal_hz
    span = float(np.ptp(times))
    if span <= 0 or np.ptp(ticks) <= 0:
        raise DataError("the board's ticks do not increase: its firmware is at fault")
    centred = times - times.mean()
    sum_squares = float(centred @ centred)
    rate = float(centred @ ticks) / sum_squares
    residual = ticks - ticks.mean() - rate * centred
    scatter = math.sqrt(float(residual @ residual) / (len(times) - 2) / sum_squares)
    uneven = float(np.ptp(trips[kept])) / 2 * math.sqrt(2 / 3) / span
    return Clock(rate, math.hypot(scatter, uneven, host_uncertainty), span, int(kept.sum()))


def _unwrapped(raw: NDArray[np.int64], expected: NDArray[np.float64]) -> NDArray[np.float64]:
    """Ticks (n,) since the first, of counts modulo 2^32; ``expected`` tells their wraps."""
    steps = np.diff(raw) % WRAP
    wraps = np.rint((np.diff(expected) - steps) / WRAP)
    return np.concatenate([[0.0], np.cumsum(steps + WRAP * np.maximum(wraps, 0))])


def with_stated(found: Clock, stated: float, rate: float = 1.0) -> Clock:
    """Together with what is stated: the ``rate`` within ``stated`` (standard)."""
    weights = found.uncertainty**-2, (stated or math.inf) ** -2
    both = (weights[0] * found.rate + weights[1] * rate) / sum(weights)
    return replace(found, rate=both, uncertainty=sum(weights) ** -0.5)
