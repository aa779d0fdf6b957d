"""Whether residuals repeat with the rotor's angle, and how often a turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.dense_products import square

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

MOST = 60  # periods a turn that are looked for
STANDS_OUT = 15.0  # of a count's power over what noise gives: exp(-15), for each of 60
PEAK = 4.0  # times the middle of its neighbours' powers
TURNING = 0.02  # of the largest speed: below it the angle hardly changes
GAP = 4  # intervals without a reading that may be amid a row
SAMPLED = 2.0  # rad of a period in a sample that still show it
BEST = 4
LEAST_STEP = 1e-9  # rad
TURN = 2 * np.pi


@dataclass(frozen=True)
class Turned:
    """One channel's residuals (n,) and the rotor's angle and step (rad) at each."""

    residual: Floats
    angle: Floats
    step: Floats


def periods_a_turn(records: Sequence[Sequence[Turned]], peak: float = PEAK) -> list[int]:
    """The counts that stand out of some kind of residual's power by angle, the strongest first.

    ``records``: the channels of each capture, in one order. ``peak``: over its neighbours.
    """
    strength = np.zeros(MOST + 1)
    for kind in zip_longest(*records):  # what one channel fits badly must not hide another's peak
        power = np.sum([_power(channel) for channel in kind if channel is not None], axis=0)
        strength = np.maximum(strength, np.where(_stands(power, peak), power, 0.0))
    found = np.flatnonzero(strength)
    return [int(n) for n in found[np.argsort(-strength[found])][:BEST]]


def _stands(power: Floats, peak: float) -> NDArray[np.bool_]:
    """Which counts' powers (MOST + 1,) stand out of their neighbours'."""
    counts = range(1, MOST + 1)
    middle = np.array([np.inf, *(np.median(power[max(n - 8, 1) : n + 9]) for n in counts)])
    return np.asarray((power > STANDS_OUT) & (power > peak * middle))


def turned(record: MotorRecord, departures: Sequence[Floats], angle: Floats) -> list[Turned]:
    """The residuals of a capture while its rotor turns; ``angle`` (count,) is the model's."""
    speed = np.abs(np.gradient(angle))
    turning = speed > TURNING * speed.max()
    out = []
    for m, left in zip(record.measured, departures, strict=True):
        at = turning[m.keep]
        if int(at.sum()) >= MOST and (m.block.name != POSITION or len(record.measured) == 1):
            out.append(_less_its_turn(Turned(left[at], angle[m.keep][at], speed[m.keep][at])))
    return out


def recurring(residual: Floats, keep: Indices, angle: Floats, period: float) -> Floats:
    """What of a channel's residuals (n,) may repeat with every ``period`` (rad) of the angle.

    ``angle`` (count,) on the grid, of which ``keep`` (n,) are the readings. Each is taken less the
    mean over the period about it, where the rotor is within a motion, and the readings are within a
    row, by a period at both ends: about a rest, what repeats can't be told from friction that
    varies.
    """
    speed = np.abs(np.gradient(angle))
    path = _path(angle)[keep]
    rests = (speed <= TURNING * speed.max())[keep]
    rests[[0, -1]] = True
    gaps = np.flatnonzero(np.diff(keep) > GAP)
    rests[gaps] = rests[gaps + 1] = True
    since = path - np.maximum.accumulate(np.where(rests, path, 0.0))
    until = np.minimum.accumulate(np.where(rests, path, path[-1])[::-1])[::-1] - path
    within = (since >= period) & (until >= period)
    return np.asarray((residual - _mean(residual, path, period))[within])


def _path(angle: Floats) -> Floats:
    """The way that the rotor has come (n,), rad, never at a stand."""
    return np.concatenate([[0.0], np.cumsum(np.maximum(np.abs(np.diff(angle)), LEAST_STEP))])


def _mean(r: Floats, path: Floats, period: float) -> Floats:
    """Of values (n,) over a period about each, along the path (n,)."""
    total = np.concatenate([[0.0], np.cumsum(0.5 * (r[1:] + r[:-1]) * np.diff(path))])
    ends = np.interp(path + period / 2, path, total), np.interp(path - period / 2, path, total)
    return np.asarray((ends[0] - ends[1]) / period)


def _less_its_turn(channel: Turned) -> Turned:
    """The residual less its mean over the turn about each reading: what does not repeat goes."""
    path = _path(channel.angle)
    whole = (path > TURN / 2) & (path < path[-1] - TURN / 2)
    left = channel.residual - _mean(channel.residual, path, TURN)
    return Turned(left[whole], channel.angle[whole], channel.step[whole])


def _power(channel: Turned) -> Floats:
    """|Σ r e^(i n angle)|² / Σ r² for n = 0 .. MOST; 0 of what never repeats."""
    power = np.zeros(MOST + 1)
    total = max(square(channel.residual), 1e-300)
    wave = np.exp(1j * channel.angle)
    weighed = channel.residual * np.ones_like(wave)
    for n in range(1, MOST + 1):
        weighed = weighed * wave
        shown = n * channel.step < SAMPLED
        power[n] = float(np.abs(weighed[shown].sum()) ** 2) / total
    return power
