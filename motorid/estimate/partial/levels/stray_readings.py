"""Speeds at the start of a step that no motor has: what a counter held before, or half an interval.

Under one level of its drive a motor from rest rises towards its steady speed. It neither turns
backward first nor falls back while it rises. An encoder's count that was not cleared, or an
interval that was not the counter's, shows as one to four readings that do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.partial.mechanical_signals import noise

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

MOST = 4  # readings at a start: what a counter held before it ends with its next interval
FAR = 0.15  # of the rise: what a reading departs from it, or falls back by
NOISES = 6.0  # standard deviations of a reading


def at_start(time_s: Floats, speed: Floats, onset_s: float, quantum: float) -> Bools:
    """(n,): the readings of ``speed`` after ``onset_s`` that lie where no rise from rest goes."""
    out = np.zeros(len(speed), dtype=np.bool_)
    first = int(np.searchsorted(time_s, onset_s))
    rise = speed[first:]
    if len(rise) < 4 * MOST:
        return out
    before = float(np.median(speed[:first])) if first else 0.0
    steady = float(np.median(rise[len(rise) // 2 :]))
    course = (rise[: MOST + 1] - before) * np.sign(steady - before)
    spread = noise(rise[len(rise) // 2 :])
    least = max(FAR * abs(steady - before), NOISES * spread, 2.0 * quantum)
    falls = np.diff(course) < -least
    backward = course[:MOST] < -least
    last = np.flatnonzero(falls | backward)
    if len(last):
        out[first : first + int(last[-1]) + 1] = True
    return out
