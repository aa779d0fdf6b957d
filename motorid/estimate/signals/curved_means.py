"""A voltage that was logged as means and moves within their time: its course, as the means tell it.

A level in place of a ramp of s V/s has the same flux at the ends of its time T, and half way up to
s T²/8 more: a current that rises as quickly as rows follow each other is off by as much over L
where a ramp begins or ends, enough to bias R and L. Through each mean goes a parabola that keeps
it. At either end it meets the next one on the straight line between both means, but at a jump.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.signals.voltage_jumps import least_jump

Floats = NDArray[np.float64]

ALONE = 0.5  # of a jump, by which the voltage may change before and after it


def jumps_alone(volts: Floats) -> NDArray[np.intp]:
    """Levels (n,) before which it jumped; changes as large that follow each other are a course."""
    changes = np.abs(np.diff(volts))
    beside = np.maximum(np.append(0.0, changes[:-1]), np.append(changes[1:], 0.0))
    alone = (changes > least_jump(volts)) & (beside <= ALONE * changes)
    return np.asarray(np.flatnonzero(alone) + 1, dtype=np.intp)


def move(volts: Floats) -> bool:
    """Levels (n,) between jumps differ by more than noise: they are means of a course."""
    least = least_jump(volts)
    return any(np.ptp(piece) > least for piece in np.split(volts, jumps_alone(volts)))


def parabolas(time_s: Floats, volts: Floats, shortest_s: float) -> tuple[Floats, Floats, Floats]:
    """V, V/s and V/s² (n,) at the beginning of each level, whose course is V + V/s t + V/s² t².

    ``volts`` (n,) V are means from ``time_s`` (n,) until the next; the last, whose end nobody
    tells, and those shorter than ``shortest_s`` stay levels.
    """
    steps = np.diff(time_s, append=2.0 * time_s[-1] - time_s[-2])
    between = (steps[1:] * volts[:-1] + steps[:-1] * volts[1:]) / (steps[1:] + steps[:-1])
    between[jumps_alone(volts) - 1] = np.nan
    begins, ends = np.append(np.nan, between), np.append(between, np.nan)
    begins, ends = _on(begins, volts, ends), _on(ends, volts, begins)
    bent = 3.0 * (2.0 * volts - begins - ends)
    flat = steps < shortest_s
    flat[-1] = True
    steps = np.where(flat, 1.0, steps)
    slopes = np.where(flat, 0.0, (ends - begins + bent) / steps)
    return np.where(flat, volts, begins), slopes, np.where(flat, 0.0, -bent / steps**2)


def _on(ends: Floats, volts: Floats, others: Floats) -> Floats:
    """V (n,) at one end of each level: beside a jump as straight on as at the other end, and beside
    two the level.
    """
    straight = np.where(np.isnan(others), volts, 2.0 * volts - others)
    return np.where(np.isnan(ends), straight, ends)
