"""Stamps that step back though the logger went on: a counter that wraps, a clock that begins anew.

A counter of 32 bits in µs wraps every 71.6 min. A logger that restarts counts from its first stamp
again. Both leave every row right but for what is added to its stamp.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Places = NDArray[np.intp]

BITS = (16, 24, 31, 32)  # of a counter
PARTS = (1.0, 1e-3, 1e-6)  # of its counts a unit of the file: µs that were written in ms, or in s
DAY_S = 86400.0  # a time of day
FOLLOWS = 2.5  # usual periods: a wrapped stamp follows the one before it within that
FEWEST = 64  # rows of each run of a file
ANEW = 10.0  # usual periods: a later run begins so near to the first stamp,
MOST_STALE = 3  # rows that a logger writes before its clock is set
FEWEST_BEHIND = 16  # rows that advance behind them
BETWEEN = 10.0  # and is placed so long after the run before it


def continued(stamps: Floats, unit_s: float, notes: list[str]) -> Floats:
    """The stamps (rows,) in the file's unit, which advance where one of both explains every step
    back; else as they are. What was done is in ``notes``.
    """
    steps = np.diff(stamps)
    back = np.flatnonzero(steps < 0.0)
    ahead = steps[steps > 0.0]
    if not len(back) or not len(ahead) or not np.isfinite(stamps).all():
        return stamps
    usual = float(np.median(ahead))
    size = next((r for r in _ranges(unit_s) if _wraps(stamps, steps[back], r, usual)), None)
    if size is not None:
        notes.append(
            f"the time wraps by {size:.10g} at {_times(len(back))}, as a counter does: it is "
            "continued there"
        )
        return _behind(stamps, back, np.full(len(back), size))
    if not _begins_anew(stamps, back, usual):
        return stamps
    notes.append(
        f"the time begins anew at {_times(len(back))}: the rows from there are taken for another "
        "run of the same motor, behind a pause"
    )
    return _behind(stamps, back, BETWEEN * usual - steps[back])


def stale(stamps: Floats) -> int:
    """Rows at the start whose stamps are from before the clock was set to zero: all others advance,
    from below those. 0: there are none.
    """
    steps = np.diff(stamps)
    back = np.flatnonzero(~(steps > 0.0))
    if len(stamps) < FEWEST_BEHIND or len(back) != 1 or back[0] >= MOST_STALE:
        return 0
    return int(back[0]) + 1 if steps[back[0]] < 0.0 else 0


def without_stale(stamps: Floats, unit_s: float, notes: list[str]) -> int:
    """How many ``stale`` rows to leave out, with a note; none where a counter has wrapped."""
    count = stale(stamps)
    if not count or continued(stamps, unit_s, []) is not stamps:
        return 0
    rows = "row" if count == 1 else f"{count} rows"
    notes.append(
        f"the first {rows} left out: stamped {stamps[0]:.10g}, before the clock was set to "
        f"{stamps[count]:.10g}"
    )
    return count


def _times(count: int) -> str:
    return "one place" if count == 1 else f"{count} places"


def _ranges(unit_s: float) -> Iterator[float]:
    """Ranges of counters in the file's unit, the smallest first."""
    yield from sorted({DAY_S / unit_s, *(2.0**bits * part for bits in BITS for part in PARTS)})


def _wraps(stamps: Floats, back: Floats, size: float, usual: float) -> bool:
    """With ``size`` added every step back is a usual one, and all stamps lie within it."""
    after = back + size
    return bool(
        np.ptp(stamps) < size * (1.0 + 1e-9) and after.min() > 0.0 and after.max() < FOLLOWS * usual
    )


def _begins_anew(stamps: Floats, back: Places, usual: float) -> bool:
    """Every run is long, advances, and begins about where the first one did."""
    edges = np.r_[0, back + 1, len(stamps)]
    if np.diff(edges).min() < FEWEST:
        return False
    begun = np.abs(stamps[back + 1] - stamps[0])
    then = stamps[back + 2] - stamps[back + 1]  # no single row that stepped back
    return bool(begun.max() <= ANEW * usual and then.max() <= ANEW * usual)


def _behind(stamps: Floats, back: Places, more: Floats) -> Floats:
    """Stamps (rows,) with so much more from each place on."""
    added = np.zeros(len(stamps))
    added[back + 1] = more
    return np.asarray(stamps + np.cumsum(added))


def single(stamps: Floats, readings: Sequence[Floats]) -> NDArray[np.bool_]:
    """Rows (rows,) that are no second copy of the row before: stamp and all readings."""
    same = stamps[1:] == stamps[:-1]
    for values in readings:
        same &= (values[1:] == values[:-1]) | (np.isnan(values[1:]) & np.isnan(values[:-1]))
    return np.concatenate([[True], ~same])
