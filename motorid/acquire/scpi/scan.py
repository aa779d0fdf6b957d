"""Inputs that a DAQ reads one after another, each reading with its time by the DAQ's own clock.

A row is one scan, and its stamp is that of the scan's last reading. How long before it an input was
read is a fact of that channel: its delay. An instrument does not say when within its reading the
stamp was taken. So a delay is in doubt by the time between two inputs, and by the stamps' step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.scpi.dialect import CHANNEL, READING, TIME
from motorid.capture.stamp_grid import grid_of
from motorid.errors import LinkError

Floats = NDArray[np.float64]
WITHIN = 12.0**0.5  # of a time that lies anywhere in an interval: standard


@dataclass(frozen=True)
class Scans:
    """Readings (n,) by input; seconds by which each input lies before ``time_s`` (n,)."""

    time_s: Floats
    readings: Mapping[str, Floats]
    late_s: Mapping[str, float]
    late_uncertainty_s: float  # standard, of each
    is_uniform: bool
    period_uncertainty: float  # standard, relative
    note: str


def scans_of(values: Floats, elements: Sequence[str], inputs: Sequence[str]) -> Scans:
    """The scans in an answer's numbers. Raises LinkError where it does not hold whole scans."""
    width = len(elements)
    if len(values) % width:
        raise LinkError(
            f"the recorder answers with {len(values)} numbers, and a reading has {width} "
            f"({', '.join(elements)}): correct scan.elements in its dialect"
        )
    table = np.asarray(values, dtype=np.float64).reshape(-1, width)
    reading, time, channel = (table[:, elements.index(one)] for one in (READING, TIME, CHANNEL))
    found = {name: np.flatnonzero(channel == float(name)) for name in inputs}
    count = min(map(len, found.values()))  # a scan that was cut short is left out
    if not count:
        lacking = next(name for name, rows in found.items() if not len(rows))
        raise LinkError(f"the recorder has nothing on input {lacking}: is it in its scan list?")
    stamps = np.stack([time[rows[:count]] for rows in found.values()])  # (inputs, n)
    if not np.all(stamps[:, 1:].min(axis=0) >= stamps[:, :-1].max(axis=0)):  # also where NaN
        raise LinkError("the recorder's readings are no scans one after another: are some missing?")
    return _timed({name: reading[rows[:count]] for name, rows in found.items()}, stamps)


def _timed(readings: Mapping[str, Floats], stamps: Floats) -> Scans:
    """With the one time of each scan that a capture has."""
    last = stamps.max(axis=0)
    late = (last - stamps).mean(axis=1)
    apart = np.diff(np.sort(late)).mean() if len(late) > 1 else 0.0
    step = np.diff(np.unique(stamps)).min() if np.ptp(stamps) else 0.0  # of theirs, or more
    grid = grid_of(last, np.arange(len(last), dtype=np.float64))
    even = grid is not None and np.array_equal(grid.places, np.arange(len(last)))
    time_s = grid.period * grid.places if grid is not None and even else last - last[0]
    period_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else math.nan
    return Scans(
        time_s=time_s,
        readings=readings,
        late_s=dict(zip(readings, map(float, late), strict=True)),
        late_uncertainty_s=math.hypot(apart, step) / WITHIN,
        is_uniform=even,
        period_uncertainty=grid.uncertainty if grid is not None and even else 0.0,
        note=(
            f"a scan of {period_s:.3g} s reads its inputs one after another, the first "
            f"{float(late.max()):.3g} s before the last: each channel's delay says so, and what is "
            "faster than a scan does not show"
        ),
    )
