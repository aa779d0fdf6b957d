"""Speeds of a log that stand far from all around them: lost edges, bounces, sparks of the brushes.

A speed by the time between two edges of an encoder is many times too high if an edge bounces, and
of the wrong sign if a line is late. No inertia follows that. The median of seven readings does not
see it, and leaves every rise and fall as it is. A short pulse of the drive moves a motor, too:
beside one only readings larger than all other speeds count. Where a current is
read, only those beyond the range of the others do: a fit with one looks for drop-outs itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.capture.units import COMMAND
from motorid.estimate.diagnosis.faults.readings.spikes import without
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.neighbour_noise import running_median

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

DRIVES = (VOLTAGE, COMMAND)
SIDE = 3  # readings on either side, whose median is the motion's
SCATTER, STEPS = 10.0, 3.0  # times the usual departure from that median, and steps of the speed
FAR, BULK = 0.2, (1.0, 99.0)  # of what the medians span, in per cent of them
FEWEST = 12  # departures, of which fewer may be spikes alone
CHANGE = 0.1  # of what the drive spans: a pulse
LARGER = 1.5  # times the highest speed: no pulse of the drive
MOST = 0.25  # of the readings: of more the median is none of the motion's
ACTION = (
    "count edges over a fixed time, debounce the encoder's lines in hardware, or keep its leads "
    "from those of the motor"
)


def removed(captures: Sequence[Capture]) -> tuple[list[Capture], tuple[Suspect, ...]]:
    """The captures without the spikes of their speeds, and what is said of those."""
    out, said = [], []
    for k, capture in enumerate(captures):
        speed, found = capture.get(SPEED), find(capture)
        if speed is None or not found.any():
            out.append(capture)
            continue
        where = f" in run {k + 1}" if len(captures) > 1 else ""
        out.append(replace(capture, channels={**capture.channels, SPEED: without(speed, found)}))
        said.append(_said(speed, found, where))
    return out, tuple(said)


def find(capture: Capture) -> Bools:
    """(n,): the readings of the speed that are spikes; none of more than ``MOST``."""
    speed, spikes = capture.get(SPEED), np.zeros(len(capture), dtype=np.bool_)
    if speed is None or speed.unsigned or capture.program is not None:
        return spikes
    known = np.flatnonzero(np.isfinite(speed.values))
    if len(known) < 4 * (2 * SIDE + 1):
        return spikes
    values = speed.values[known]
    motion = running_median(values, SIDE)
    off = np.abs(values - motion)
    low, high = np.percentile(motion, BULK)
    least = max(_usual(off), STEPS * speed.resolution, FAR * float(high - low))
    beyond = (values > high + least) | (values < low - least)
    beyond |= CURRENT not in capture.channels
    huge = np.abs(values) > LARGER * float(np.abs(motion).max())
    found = (off > least) & (huge | (beyond & ~_pulsed(capture)[known]))
    if found.any() and float(np.mean(found)) <= MOST:
        spikes[known[found]] = True
    return spikes


def _usual(off: Floats) -> float:
    """Departures from the median that noise or counts make: most readings that are counts agree
    with it, and the others differ by one count or two.
    """
    some = off[off > 0.0]
    counts = STEPS * float(np.median(some)) if len(some) >= FEWEST else 0.0
    return max(SCATTER * float(np.median(off)), counts)


def _pulsed(capture: Capture) -> Bools:
    """(n,): readings within ``SIDE`` of a pulse of the drive that is no longer than that."""
    drive = next((capture.channels[n].values for n in DRIVES if n in capture.channels), None)
    if drive is None:
        return np.zeros(len(capture), dtype=np.bool_)
    drive = np.nan_to_num(drive)
    pulse = np.abs(drive - running_median(drive, SIDE)) > CHANGE * float(np.ptp(drive))
    return np.asarray(np.convolve(pulse, np.ones(2 * SIDE + 1), "same") > 0.5)


def _said(speed: Channel, found: Bools, where: str) -> Suspect:
    count = int(found.sum())
    readings = f"{count} readings" if count > 1 else "one reading"
    known = np.isfinite(speed.values)
    values = speed.values[known]
    farthest = float(np.abs(values - running_median(values, SIDE))[found[known]].max())
    share = f"{100.0 * count / len(found):.2g} % of all"
    evidence = (
        f"{readings} of the speed{where} ({share}) stand alone, up to {farthest:.3g} {speed.unit} "
        "from those around, which no inertia follows; the fit leaves them out"
    )
    return Suspect("spikes", "speed", evidence, ACTION, "named", allowed=True)
