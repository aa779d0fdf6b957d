"""Jumps of a voltage that was logged as means: each mean says when, within its time, it jumped.

    mean = f before + (1 − f) after

A model that takes the mean for the whole time lets the current rise too early and too slowly, by
up to a V T²/(8 L) in one reading of every step: enough to bias L.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.neighbour_noise import neighbour_noise

Floats = NDArray[np.float64]

CLEAR, SHARE = 8.0, 0.05  # a jump in standard deviations of a reading, and of the range
FLAT = 0.2  # of a jump, by which the voltage may change before and after it
FEWEST = 8  # readings


def within(volts: Floats) -> NDArray[np.intp]:
    """Readings (n,) whose own time holds a jump, from a level to another."""
    if len(volts) < FEWEST:
        return np.zeros(0, dtype=np.intp)
    deviation = neighbour_noise(volts)
    before, here, after = volts[1:-3], volts[2:-2], volts[3:-1]
    rise = after - before
    far = np.abs(rise) > SHARE * float(np.ptp(volts))
    between = (here - before) * (after - here) > 0.0
    inside = np.minimum(np.abs(here - before), np.abs(after - here)) > CLEAR / 2.0 * deviation
    flat = np.maximum(np.abs(before - volts[:-4]), np.abs(volts[4:] - after))
    return np.flatnonzero(far & between & inside & (flat <= FLAT * np.abs(rise))) + 2


def split(begun: Floats, ends: Floats, volts: Floats, quiet: Floats) -> tuple[Floats, Floats]:
    """When every level begins, and the levels (m,): means (n,) over ``begun`` to ``ends``, those
    that hold a jump as the two levels about it. ``quiet`` (n,): means freed of noise.
    """
    at = within(volts)
    if not len(at):
        return begun, quiet
    before, after = quiet[at - 1], quiet[at + 1]
    share = (volts[at] - after) / (before - after)
    moments = begun[at] + share * (ends[at] - begun[at])
    levels = quiet.copy()
    levels[at] = before
    return np.insert(begun, at + 1, moments), np.insert(levels, at + 1, after)
