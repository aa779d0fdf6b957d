"""Rows that a log lacks under stamps that count on: all channels jump along their own slopes.

Lines through the readings before and after a place meet in its middle. Where m rows are missing,
they meet m periods apart, in every channel. Where many are missing, the slope has changed meanwhile
and only the jump is left: far larger than any other change, at a voltage that stays.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.signals.neighbour_noise import neighbour_noise

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SIDES = (5, 10, 20)  # rows of each line
NARROW = SIDES[0]
SURE = 0.22  # periods: standard uncertainty below which a place says how many rows it lacks
CLEAR = 4.0  # standard uncertainties from nothing
AGREE = 9.0  # chi-square of the channels about one number of rows
WHOLE = 0.35  # periods by which a number of rows may miss a whole one
BENT = 0.2  # rows that the places beside seem to lack, at most: else the signal bends
FEWEST = 3  # places
OTHERS = 0.25  # of them, at most: places that miss no whole number of rows
QUIET = 8.0  # noises by which the voltage may bend beside a place
LATE = 15  # rows for which a bend of the voltage may still bend a current
PULLS = 6.0  # standard uncertainties of the jump and 3 of both slopes
ROUNDED = 1e-9  # of a channel's range: what a change of units leaves of an equal reading
SMALL = 10  # percentile of the changes of a channel, of those that are any
BEYOND = 4.0  # times the largest other change of the speed: a stretch is missing


@dataclass(frozen=True)
class Lost:
    """``places`` (rows) that something is missing before, and how many rows; 0: a stretch."""

    places: NDArray[np.intp]
    rows: Floats


def suspects(capture: Capture, motor: Floats | None = None) -> list[Suspect]:
    """Rows that a log lacks; ``motor``: R, L, K, B, J, T0 as they seem with the others."""
    lost = find(capture)
    if lost is None:
        return []
    stretches = lost.rows == 0.0
    first = f"first at {capture.time_s[lost.places[0]]:.4g} s"
    if stretches.any():
        evidence = (
            f"the speed jumps where the voltage stays, {int(stretches.sum())} times and {first}, "
            f"{BEYOND:g} times as far as it ever changes from row to row: a stretch is missing"
        )
    else:
        evidence = (
            f"current and speed jump along their slopes by whole rows at {len(lost.places)} "
            f"places, {first}: {lost.rows.sum():.0f} rows are missing there, and the stamps do "
            "not show it"
        )
    action = "log with the logger's own stamps, and import the file before anybody cut it"
    moves = dict.fromkeys(("L", "J"), math.inf)
    if motor is not None and capture.get(POSITION) is not None:  # it turns farther in the time left
        share = float(lost.rows.sum()) / len(capture)
        moves |= {"K": share * motor[2], "B": 2.0 * share * motor[3], "T0": share * motor[5]}
    return [Suspect("samples_dropped", "time", evidence, action, "named", moves)]


def find(capture: Capture) -> Lost | None:
    """What a log lacks under stamps that count on; None: nothing, or nothing shows it."""
    names = [n for n in (CURRENT, SPEED, POSITION) if capture.get(n) is not None]
    volts = capture.get(VOLTAGE)
    if capture.program is not None or volts is None or not names or len(capture) < 8 * SIDES[-1]:
        return None
    if any(not np.isfinite(capture.channels[n].values).all() for n in (VOLTAGE, *names)):
        return None
    columns = [capture.channels[n].values for n in names]
    stretches = _torn(capture)
    if len(stretches):
        return Lost(stretches, np.zeros(len(stretches)))
    found = [_single(capture, columns, side) for side in SIDES]
    return max((f for f in found if f), key=lambda f: len(f.places), default=None)


def _single(capture: Capture, columns: Sequence[Floats], side: int) -> Lost | None:
    """Places that lack whole rows, by lines through ``side`` rows; None: too few are clear."""
    usable = _steady(capture.channels[VOLTAGE].values, LATE, side) & _even(capture.time_s, side)
    lines = [_Lines.of(values, side) for values in columns]
    weight = np.sum([s.slope**2 / s.variance for s in lines], axis=0) + 1e-300
    pull = np.sum([s.jump * s.slope / s.variance for s in lines], axis=0)
    missing = pull / weight
    disagree = sum((s.jump - missing * s.slope) ** 2 / s.variance for s in lines)
    sure = 1.0 / np.sqrt(weight)
    clear = usable & (sure < SURE) & (disagree < AGREE) & (np.abs(missing) > CLEAR * sure)
    clear &= np.abs(_beside(pull, side) / _beside(weight, side)) < BENT
    clear &= _peaks(np.where(usable, missing, 0.0), side) & (np.abs(missing) > WHOLE)
    whole = np.rint(missing)
    right = clear & (whole >= 1.0) & (np.abs(missing - whole) < WHOLE)
    others = int((clear & ~right).sum())
    if right.sum() < FEWEST or others > OTHERS * right.sum():
        return None
    return Lost(np.flatnonzero(right) + side, whole[right])


@dataclass(frozen=True)
class _Lines:
    """Of each place between two rows, (n - 2 side + 1,): jump between two lines, and slopes."""

    jump: Floats
    before: Floats  # slope, in units a row
    after: Floats
    variance: float  # of the jump

    @classmethod
    def of(cls, values: Floats, side: int) -> _Lines:
        """Lines through ``side`` readings before and after."""
        at = np.arange(side) - (side - 1) / 2.0
        slope = np.convolve(values, at[::-1], "valid") / (at @ at)
        mean = np.convolve(values, np.ones(side), "valid") / side
        reach = side / 2.0
        left, right = slope[:-side], slope[side:]
        jump = (mean[side:] - reach * right) - (mean[:-side] + reach * left)
        noise = max(_noise(values), 0.5 * _step(values))
        variance = 2.0 * noise**2 * (1.0 / side + reach**2 / float(at @ at))
        return cls(jump, left, right, max(variance, 1e-300))

    @property
    def slope(self) -> Floats:
        """Mean of both sides; zero where they go opposite ways."""
        same = self.before * self.after > 0.0
        return np.where(same, 0.5 * (self.before + self.after), 0.0)


def _noise(values: Floats) -> float:
    """Standard deviation of a reading, from third differences."""
    return max(neighbour_noise(values, order=3), 1e-6 * float(np.ptp(values)))


def _step(values: Floats) -> float:
    """A small change between neighbours: of a coarse channel that mostly stays, whose usual third
    difference is nothing, its resolution. A smooth one has far smaller changes than its slopes.
    """
    changes = np.abs(np.diff(values))
    changes = changes[changes > ROUNDED * float(np.ptp(values))]
    return float(np.percentile(changes, SMALL)) if len(changes) else 0.0


def _steady(volts: Floats, late: int, side: int) -> Bools:
    """Places beside which the voltage does not bend, nor up to ``late`` rows before."""
    bends = np.abs(np.diff(volts, 2)) > QUIET * _noise(volts) * math.sqrt(6.0)
    recent = np.convolve(bends, np.ones(late + 1), "full")[: len(bends)]  # a reading may be late
    count = np.convolve(recent, np.ones(2 * side - 2), "valid")
    return np.asarray(count < 0.5)


def _even(time_s: Floats, side: int) -> Bools:
    """Places with no pause in the stamps among the rows of both lines."""
    steps = np.diff(time_s)
    pauses = np.abs(steps / np.median(steps) - 1.0) >= 0.5
    return np.asarray(np.convolve(pauses, np.ones(2 * side - 1), "valid") < 0.5)


def _beside(values: Floats, side: int) -> Floats:
    """Sum over the places whose lines on one side at most touch those of a place."""
    flank = np.ones(side)
    kernel = np.concatenate([flank, np.zeros(2 * side + 1), flank])
    return np.convolve(np.pad(values, 2 * side), kernel, "valid")


def _peaks(missing: Floats, side: int) -> Bools:
    """Places at which most is missing for ``side`` rows around."""
    sizes = np.abs(np.pad(missing, side))
    around = np.lib.stride_tricks.sliding_window_view(sizes, 2 * side + 1)
    return np.asarray(np.abs(missing) >= around.max(axis=1))


def _torn(capture: Capture) -> NDArray[np.intp]:
    """Rows before which the speed jumps along its slopes farther than it ever changes."""
    channel, side = capture.get(SPEED), NARROW
    if channel is None:
        return np.array([], dtype=np.intp)
    usable = _steady(capture.channels[VOLTAGE].values, 0, side) & _even(capture.time_s, side)
    changes = np.abs(np.diff(channel.values))
    lines = _Lines.of(channel.values, side)
    u, way = math.sqrt(lines.variance), np.sign(lines.jump)
    least = 3.0 * u / side  # of a slope
    along = (way * lines.before > least) & (way * lines.after > least)
    far = np.abs(lines.jump) > PULLS * u
    out = []
    for k in np.flatnonzero(usable & along & far & _peaks(lines.jump, side)).tolist():
        others = np.concatenate([changes[: max(k - 1, 0)], changes[k + 2 * side :]])
        if abs(lines.jump[k]) > BEYOND * float(np.max(others, initial=0.0)):
            out.append(k + side)
    return np.array(out, dtype=np.intp)
