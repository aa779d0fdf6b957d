"""The sign of a drive that a log holds as a magnitude: a PWM of 0 to 255 beside a pin for the way.

A motor that is driven ends each level turning the way that it is driven. If the drive is never
negative though the motor turns both ways, each level takes the sign of the speed at its end. If a
straight line through an offset explains the ends as well (an inverter whose middle is its stop),
or if the motor turns against these signs for long, the drive stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED, VOLTAGE, Channel
from motorid.capture.units import COMMAND

Floats = NDArray[np.float64]

OFF = 0.02  # of the highest drive: none
CHANGE = 0.02  # of the highest drive: another level
HELD = 0.3  # of the rows: a drive that changes more often has no levels
TURNS = 0.1  # of the usual top speed: it turns
FEWEST = 5  # readings each way
END = 3  # part of a level that is its end
AGREE = 0.9  # of the readings at speed: they turn the way of their level
WORSE = 0.5  # of what a line with an offset leaves of the ends: the signs explain them better


def with_sign(
    channels: Mapping[str, Channel], time_s: Floats, notes: list[str]
) -> dict[str, Channel]:
    """``channels`` with the sign of a voltage or command that is a magnitude, and a note."""
    out = dict(channels)
    speed = _speed(channels, time_s)
    if speed is None:
        return out
    for name in (VOLTAGE, COMMAND):
        channel = channels.get(name)
        if channel is None:
            continue
        signs = signs_of(channel.values, speed)
        if signs is None:
            continue
        out[name] = replace(channel, raw=np.abs(channel.raw) * signs, unsigned=False)
        notes.append(
            f"the {name.replace('_', ' ')} is never negative though the motor turns both ways: "
            "each level has the sign of the speed at its end"
        )
    return out


def _speed(channels: Mapping[str, Channel], time_s: Floats) -> Floats | None:
    speed, position = channels.get(SPEED), channels.get(POSITION)
    if speed is not None:
        return None if speed.unsigned else speed.values
    if position is None or len(time_s) < 2:
        return None
    return np.asarray(np.gradient(position.values, time_s))


def signs_of(drive: Floats, speed: Floats) -> Floats | None:
    """(n,) of ±1 for each reading of ``drive``, a magnitude; None: it is none, or nothing tells."""
    if not (np.isfinite(drive).all() and np.isfinite(speed).all()) or drive.min(initial=0.0) < 0:
        return None
    most, top = float(drive.max(initial=0.0)), float(np.percentile(np.abs(speed), 95))
    driven = drive > OFF * most
    turning = np.abs(speed) > TURNS * top
    ways = [int((driven & turning & (way * speed > 0)).sum()) for way in (1, -1)]
    if not most or not top or min(ways) < FEWEST:
        return None
    signs, ends = np.ones(len(drive)), []
    for start, stop in _levels(drive, most):
        end = slice(max(stop - max((stop - start) // END, 1), start), stop)
        last = float(np.median(speed[end]))
        ends.append((float(np.median(drive[end])), last))
        if driven[start] and abs(last) > TURNS * top:
            signs[start:stop] = np.sign(last)
    counted = driven & turning
    if len(np.unique(signs[driven])) < 2:
        return None  # a few readings of a sensor that errs
    if float(np.mean((signs * speed > 0)[counted])) < AGREE or not _explains(*np.array(ends).T):
        return None
    return signs


def _levels(drive: Floats, most: float) -> Iterator[tuple[int, int]]:
    """[start, stop) of the levels of a drive; of what changes all the time, what lies between its
    zeros.
    """
    changes = np.abs(np.diff(drive)) > CHANGE * most
    switched = np.diff(drive > OFF * most)
    held = float(np.mean(changes)) <= HELD
    edges = [
        0,
        *(np.flatnonzero(changes | switched if held else switched) + 1).tolist(),
        len(drive),
    ]
    yield from pairwise(edges)


def _explains(drive: Floats, speed: Floats) -> bool:
    """Whether signs explain the ends of the levels better than an offset of the drive does."""
    way = np.sign(speed)
    signed = np.column_stack([way * drive, way * (drive > 0)])
    shifted = np.column_stack([drive, np.ones(len(drive))])
    left = [
        float(((speed - m @ np.linalg.lstsq(m, speed, rcond=None)[0]) ** 2).sum())
        for m in (signed, shifted)
    ]
    return left[0] < WORSE * left[1]
