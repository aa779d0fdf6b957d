"""Rows of a log that a program put between the readings: on straight lines, or as repetitions.

A table that was brought to a finer grid has many rows and few readings. Taken for readings, the
rows between smear every jump over one of the log's own periods. Rows are told by all channels: each
bends (or changes) at every ``factor``-th row alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Gap
from motorid.estimate.results.estimate import Diagnostic

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

READ = (CURRENT, SPEED, POSITION, VOLTAGE)  # what is looked at
MOTOR = (CURRENT, SPEED, POSITION)  # one of these must bend: a voltage is often set every few rows
FACTORS = range(2, 201)
ON = 0.98  # of a channel's bends, at least, stand on the rows of its own readings
BUSY = 0.3  # of those rows, at least, bend
FEWEST = 20  # readings that are left
DIGITS = 2.01e-6  # of the largest reading: by how much the rounding to seven digits bends a line
ROUNDED = 2.01  # resolutions: the most that rounding bends a straight line
EVEN = 1e-3  # of a period: stamps of a grid


@dataclass(frozen=True)
class Upsampled:
    """Rows ``first``, ``first + factor``, ... are readings; ``held``: the others repeat them."""

    first: int
    factor: int
    held: bool


def own_readings(capture: Capture) -> tuple[Capture, Diagnostic | None]:
    """The capture without such rows, and what is said of them; as it is where there are none."""
    found = find(capture)
    if found is None:
        return capture, None
    return _thinned(capture, found), _said(capture, found)


def find(capture: Capture) -> Upsampled | None:
    """Where the readings of a log stand among rows that a program made; None: each is one."""
    if capture.program is not None or len(capture) < 2 * FEWEST or not _even(capture):
        return None
    tables = [
        (name, np.asarray(channel.raw, dtype=np.float64), channel.resolution / abs(channel.scale))
        for name in READ
        if (channel := capture.get(name)) is not None
    ]
    if len(tables) < 2 or not all(np.isfinite(raw).all() for _, raw, _ in tables):
        return None
    for held in (True, False):
        bends = {name: _bends(raw, step, held) for name, raw, step in tables}
        found = _lattice(bends)
        if found is not None:
            return Upsampled(*found, held)
    return None


def _even(capture: Capture) -> bool:
    periods = np.diff(capture.ticks)
    middle = float(np.median(periods))
    return middle > 0 and bool(np.abs(periods - middle).max() <= max(1.0, EVEN * middle))


def _bends(raw: Floats, resolution: float, held: bool) -> Bools:
    """(n,): rows at which a channel changes (``held``), or its slope does; in raw units."""
    floor = max(DIGITS * float(np.abs(raw).max()), ROUNDED * resolution)
    out = np.zeros(len(raw), dtype=np.bool_)
    if held:
        out[1:] = raw[1:] != raw[:-1]
    else:
        out[1:-1] = np.abs(raw[2:] - 2.0 * raw[1:-1] + raw[:-2]) > floor
    return out


def _lattice(bends: dict[str, Bools]) -> tuple[int, int] | None:
    """First row and factor: the largest that the bends of all channels agree on."""
    rows = next(iter(bends.values())).size
    places = {name: np.flatnonzero(bend) for name, bend in bends.items()}
    anywhere = np.flatnonzero(np.logical_or.reduce(list(bends.values())))
    most = max(map(len, places.values()))
    motor = max(len(places[name]) for name in MOTOR if name in places)
    for factor in reversed(FACTORS):
        own = math.ceil(rows / factor)  # rows, at most
        if rows < factor * FEWEST or ON * most > own or motor < BUSY * (rows / factor):
            continue  # whichever row is the first
        first = int(_by_phase(anywhere, factor).argmax())
        on = {name: int(_by_phase(one, factor)[first]) for name, one in places.items()}
        if any(on[name] < ON * len(one) for name, one in places.items()):
            continue
        if max(on[name] for name in MOTOR if name in on) >= BUSY * (rows / factor):
            return first, factor
    return None


def _by_phase(places: NDArray[np.intp], factor: int) -> NDArray[np.intp]:
    """(factor,): how many of these rows are k, k + factor, ..."""
    return np.bincount(places % factor, minlength=factor)


def _thinned(capture: Capture, found: Upsampled) -> Capture:
    rows = slice(found.first, None, found.factor)
    return capture.rows(rows, _gaps(capture.gaps, found))


def _gaps(gaps: Sequence[Gap], found: Upsampled) -> tuple[Gap, ...]:
    """Each before the first reading that comes after it."""
    places = ((-(-(gap.index - found.first) // found.factor), gap) for gap in gaps)
    return tuple(replace(gap, index=max(place, 0)) for place, gap in places)


def _said(capture: Capture, found: Upsampled) -> Diagnostic:
    between = "repeat it" if found.held else "lie on straight lines to the next"
    own = found.factor * capture.period_s
    return Diagnostic(
        "rows_interpolated", "warning",
        f"one row of {found.factor} is a reading, and the rows after it {between}: the table was "
        f"interpolated. The fit takes the readings alone, {1e3 * own:.4g} ms apart. Log faster, or "
        "import the table as it was logged",
    )  # fmt: skip
