"""Stretches of no command in which the motor may coast: nobody logged whether the bridge opens.

A command of 0 brakes the motor through a closed bridge, or lets it coast. Both are fitted where a
log shows the motor turn without a command. If the closed bridge leaves far more than the parts
under drive by themselves, it was open: these parts are the answer, and the rest is a coast-down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.partial.mechanical_signals import COASTING, drive_of
from motorid.estimate.partial.without_current.likelihood import speeds_of
from motorid.estimate.results.estimate import Curve
from motorid.estimate.signals.log_sections import part

Bools = NDArray[np.bool_]

OFF = 0.02  # of the highest drive: as good as none
TURNS = 0.1  # of the highest speed, at which such a stretch begins
FEWEST = 12  # samples of a stretch
WORSE = 1.5  # times what the parts under drive leave, rms: the bridge was not closed


def parted(capture: Capture) -> tuple[list[Capture], list[Capture]]:
    """Parts under drive, and parts without one that begin at speed."""
    drive = np.abs(capture.channels[drive_of(capture.channels) or COASTING].values)
    off = ~(drive > OFF * float(np.nanmax(drive)))
    speed = np.abs(speeds_of(capture))
    top = float(np.nanpercentile(speed, 95))
    edges = [0, *(np.flatnonzero(np.diff(off)) + 1).tolist(), len(off)]
    driven, coasting, begin = [], [], 0
    for a, b in pairwise(edges):
        if off[a] and a and b - a >= FEWEST and np.nanmedian(speed[a : a + 3]) > TURNS * top:
            coasting.append((a, _rests(speed[a:b], top) + a))
            driven.append((begin, a))
            begin = b
    driven.append((begin, len(off)))
    return (
        [part(capture, a, b) for a, b in driven if b - a >= FEWEST and not off[a:b].all()],
        [_undriven(part(capture, a, b)) for a, b in coasting if b - a >= FEWEST],
    )


def _rests(speed: NDArray[np.float64], top: float) -> int:
    """Where the motor has come to rest."""
    moving = np.flatnonzero(speed > OFF * top)
    return int(moving[-1]) + 1 if len(moving) else len(speed)


def _undriven(capture: Capture) -> Capture:
    name = drive_of(capture.channels)
    others = {n: c for n, c in capture.channels.items() if n != name}
    return replace(capture, channels=others)


def left(curves: Sequence[Curve]) -> float:
    """What a fit leaves of the motion, rms, where the motor moves; infinite of a balance."""
    total = count = 0.0
    for curve in curves:
        if curve.channel not in ("speed", "position"):
            continue
        moving = np.abs(np.gradient(curve.measured)) > 0.0
        if curve.channel == "speed":
            moving = np.abs(curve.measured) > OFF * float(np.nanmax(np.abs(curve.measured)))
        total += float(np.nansum((curve.measured - curve.fitted)[moving] ** 2))
        count += float(moving.sum())
    return float(np.sqrt(total / count)) if count else np.inf
