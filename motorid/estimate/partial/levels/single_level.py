"""The one level of a drive that a step leads to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

CONSTANT = 0.02  # of its level, rms, by which a drive may vary
FEWEST = 12  # readings of a step


def level_of(time: Floats, drive: Floats) -> tuple[float, tuple[float, float] | None, float] | None:
    """The one level of a drive, when it began, and when it ends (s): infinite where the record does
    before. None where the drive has several levels, or none. Fewer than ``FEWEST`` readings behind
    its end are no level of their own: a logger's last rows, after the drive was switched off.
    """
    known = np.flatnonzero(np.isfinite(drive))
    if len(known) < FEWEST:
        return None
    time, drive = time[known], drive[known]
    size = np.abs(drive)
    # the record may begin with a long rest
    level = float(np.median(drive[size >= 0.5 * size.max()]))
    on = np.abs(drive - level) <= 0.5 * abs(level)
    first = int(np.argmax(on))
    stop = first + int(on[first:].argmin()) if not on[first:].all() else len(on)
    if not level or len(on) - stop >= FEWEST or stop - first < FEWEST:
        return None
    if float(np.std(drive[first:stop])) > CONSTANT * abs(level):
        return None
    while_rising = float(np.mean(drive[first : first + FEWEST]))
    if abs(while_rising - level) > CONSTANT * abs(level):
        return None  # a controller's start, or a supply that sags: a long record hides it
    until_s = float(time[stop]) if stop < len(time) else np.inf
    if not first:
        return level, None, until_s
    if float(np.abs(drive[:first]).max()) > 2.0 * CONSTANT * abs(level):
        return None
    half = float(time[first] - time[first - 1]) / 2.0
    return level, (float(time[first]) - half, half), until_s
