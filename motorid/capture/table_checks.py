"""What can be wrong with a foreign table: rows that cannot be used, and oddities worth a note."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motorid.capture.columns import BadCell, Columns, Source
from motorid.capture.mapping import ChannelMap, Formula
from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel, Gap
from motorid.capture.units import unit_of
from motorid.errors import DataError, UsageError

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# usual marks for "missing"; a converter's own ends (65535, -32768) are readings, and are kept
SENTINELS = (-999.0, -9999.0, -99999.0, 9999.0, 99999.0, 999999.0)
FAR = 20  # a sentinel lies this many times farther out than the rest of its column
GAP = 2.5  # a pause of so many usual periods is a gap in the record
IRREGULAR = 0.02  # relative spread of the periods that is worth saying
FEW = 0.05  # of the rows: where more repeat a stamp, stamps were rounded
SLOW_S = 1.0  # a period beyond this hardly shows a motor's dynamics
FEWEST_ONE_WAY = 5  # readings
FAST = 0.2  # of the largest voltage or speed: the motor is driven, or turns, that way
NOISE = 0.1  # of a magnitude's usual reading: below zero by so little, it is noise
STOPPED = 0.1  # of the usual speed forward: below it the motor may have stopped to turn


def header_notes(
    mapped: Mapping[str, ChannelMap],
    formulas: Mapping[str, Formula],
    header_units: Mapping[str, str],
) -> list[str]:
    """Where the file's own header contradicts the unit that a map gives to a bare column."""
    notes = []
    for quantity, one in mapped.items():
        said = header_units.get(one.expression)
        if said is None or one.expression not in formulas[quantity].columns:
            continue
        try:
            same = unit_of(quantity, said, 1.0).scale == one.unit.scale
        except UsageError:
            same = False
        if not same and one.unit.written != said and "count" not in one.unit.written:
            notes.append(
                f"the file's header gives {one.expression} in {said}, the map in "
                f"{one.unit.written}: the map was followed"
            )
    return notes


def without_told(columns: Columns, missing: Sequence[float], notes: list[str]) -> Columns:
    """The columns with NaN for every cell that a person says is a mark for "missing"."""
    values = dict(columns.values)
    for name, column in values.items():
        marks = np.isin(column, missing)
        if marks.any():
            values[name] = np.where(marks, np.nan, column)
            shown = ", ".join(f"{mark:g}" for mark in missing)
            notes.append(f"{int(marks.sum())} readings of {name} left out, as told ({shown})")
    return replace(columns, values=values)


def good_cells(
    path: Path, source: Source, columns: Columns, drop_bad: bool, notes: list[str]
) -> Columns:
    """The columns with NaN for every cell that holds no number, or a mark for a missing one.

    Raises DataError, naming the first bad cell's place, unless ``drop_bad``.
    """
    marks = _sentinels(columns)
    bad = [*columns.bad, *(_first_mark(columns, name, rows) for name, rows in marks.items())]
    if not bad:
        return columns
    first = min(bad, key=lambda cell: cell.row)
    what = f"holds {first.text!r}, not a number" if first.text else "is empty"
    if first.text.startswith("sentinel"):
        what = f"holds {first.text.removeprefix('sentinel ')}, which looks like a mark for missing"
    values = dict(columns.values)
    for name, found in marks.items():
        values[name] = np.where(found, np.nan, values[name])
    missing = np.any([np.isnan(column) for column in values.values() if len(column) > 1], axis=0)
    lost = max(1, int(np.sum(missing)))
    rows = "1 row is" if lost == 1 else f"{lost} rows are"
    if not drop_bad:
        raise DataError(
            f"{path}: {source.place(first.row)}, column {first.column!r} {what}; {rows} bad in "
            "all: repair the file, or leave such rows out with --drop-bad"
        )
    notes.append(
        f"{rows} bad, and their bad readings left out; the first: {source.place(first.row)}, "
        f"{first.column} {what}"
    )
    return replace(columns, values=values)


def _sentinels(columns: Columns) -> dict[str, Bools]:
    """Readings of a usual mark for "missing" that lie far outside the rest of their column."""
    found = {}
    for name, values in columns.values.items():
        marks = np.isin(values, SENTINELS)
        if len(values) < 2 or not marks.any() or marks.all():
            continue
        rest = np.nanmax(np.abs(values[~marks]), initial=0.0)
        far = marks & (np.abs(values) > FAR * rest)
        if far.any():
            found[name] = far
    return found


def _first_mark(columns: Columns, name: str, marks: Bools) -> BadCell:
    row = int(np.argmax(marks))
    return BadCell(row, name, f"sentinel {columns.values[name][row]:g}")


def stamps_that_advance(
    path: Path,
    source: Source,
    ticks: NDArray[np.int64],
    rows: Floats,
    drop_bad: bool,
    notes: list[str],
) -> Bools:
    """Which stamps lie after all before them. Raises DataError unless ``drop_bad`` or all do."""
    if np.all(ticks[1:] > ticks[:-1]):
        return np.ones(len(ticks), dtype=bool)
    highest = np.maximum.accumulate(ticks)
    ahead: Bools = np.r_[True, ticks[1:] > highest[:-1]]
    first = int(np.flatnonzero(~ahead)[0])
    repeats = ticks[first] == highest[first - 1]
    what = "repeats the stamp before it" if repeats else "steps back in time"
    place, lost = source.place(int(rows[first])), int((~ahead).sum())
    if not drop_bad:
        ask = "is time in the right unit and column?"
        if repeats and lost > FEW * len(ticks):
            ask = "write stamps with more digits: no uniform period explains these."
        raise DataError(
            f"{path}: {place} {what} ({lost} such in all): {ask} To leave such rows out: --drop-bad"
        )
    notes.append(f"{lost} rows left out whose stamps do not advance; the first: {place}")
    return ahead


def some_readings(path: Path, values: Mapping[str, Floats]) -> None:
    """Raises DataError where a quantity has no good reading left in any usable row."""
    for name, column in values.items():
        if not np.isfinite(column).any():
            raise DataError(
                f"{path}: no usable row holds a number for {name}: is it the right column? "
                "To do without it, leave its --map out"
            )


def gaps(ticks: NDArray[np.int64], notes: list[str]) -> tuple[Gap, ...]:
    """Pauses much longer than the usual period, as gaps; notes on how regular the stamps are."""
    steps = np.diff(ticks)
    usual = float(np.median(steps))
    late = steps > GAP * usual
    found = tuple(
        Gap(int(index) + 1, round(steps[index] / usual) - 1, "the time column pauses")
        for index in np.flatnonzero(late)
    )
    off = (steps[~late] if late.any() else steps) - usual
    spread = float(np.percentile(np.abs(off, out=off), 95, overwrite_input=True)) / usual
    if spread > IRREGULAR:
        share = f"{100 * spread:.0f} %"
        notes.append(f"irregular stamps: 5 % of periods are off by {share} or more; kept")
    if found:
        notes.append(f"{len(found)} pauses of more than {GAP:g} periods, recorded as gaps")
    if usual > SLOW_S * 1e9:
        notes.append(
            f"the usual period is {usual / 1e9:g} s, too slow to show a motor start: "
            "is the time column's unit right?"
        )
    return found


def held_samples(channels: Mapping[str, Channel]) -> dict[str, int]:
    """Channels whose readings only ever change every n samples (n > 1): channel -> n."""
    found = {}
    for name, channel in channels.items():
        values = np.asarray(channel.raw, dtype=np.float64)
        finite = np.isfinite(values)
        known = values if finite.all() else values[finite]
        changes = np.flatnonzero(known[1:] != known[:-1])
        if len(changes) < 20:
            continue
        steps = np.diff(changes)
        period = int(steps.min())
        if period > 1 and np.mean(steps % period == 0) > 0.9:
            found[name] = period
    return found


def with_magnitudes(channels: Mapping[str, Channel], notes: list[str]) -> dict[str, Channel]:
    """Marks a speed, then a current, that is never negative though the motor ran both ways."""
    out = dict(channels)
    volts, speed, current = (out.get(name) for name in (VOLTAGE, SPEED, CURRENT))
    if volts is not None and speed is not None and _is_magnitude(speed, volts, after_rest=True):
        notes.append("the speed is never negative though the voltage drives both ways: a magnitude")
        out[SPEED] = speed = replace(speed, unsigned=True)
    way = volts if speed is not None and speed.unsigned else speed
    if current is not None and way is not None and _is_magnitude(current, way):
        notes.append("the current is never negative though the motor runs both ways: a magnitude")
        out[CURRENT] = replace(current, unsigned=True)
    return out


def _is_magnitude(channel: Channel, way: Channel, after_rest: bool = False) -> bool:
    """Whether a channel is never negative though ``way`` goes both ways.

    ``after_rest``: only what follows a rest counts backward, since what has inertia turns late.
    """
    if channel.unsigned:
        return False
    known = np.isfinite(channel.values) & np.isfinite(way.values)
    values, ways = channel.values[known], way.values[known]
    fast = FAST * np.abs(ways).max(initial=0.0)
    forward, backward = values[ways > fast], values[ways < -fast]
    if after_rest and len(forward):
        least = STOPPED * float(np.median(forward))
        backward = values[_after_rest(values, ways < -fast, least)]
        backward = backward[backward > least]
    if min(len(forward), len(backward)) < FEWEST_ONE_WAY:
        return False
    least = float(min(np.median(forward), np.median(backward)))
    return least > 0 and float(values.min(initial=0.0)) >= -NOISE * least


def _after_rest(values: Floats, stretches: Bools, least: float) -> Bools:
    """The readings of each stretch of True that come after its least one, where that is a rest."""
    out = np.zeros_like(stretches)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stretches, [False]]).astype(int)))
    for start, stop in edges.reshape(-1, 2):
        before = max(start - 1, 0)  # from which the motor may have started
        lowest = before + int(np.argmin(values[before:stop]))
        if values[lowest] < least:
            out[max(lowest, start) : stop] = True
    return out


def capture_notes(capture: Capture, held: Mapping[str, int], static: bool) -> list[str]:
    """Notes on channels: constant, held, at odds with each other."""
    notes = []
    for name, channel in capture.channels.items():
        if np.nanmax(channel.raw) == np.nanmin(channel.raw):
            notes.append(f"{name} never changes: is it the right column?")
    for name, period in held.items():
        notes.append(f"{name} is held: it changes only every {period} samples")
    position, speed = capture.get(POSITION), capture.get(SPEED)
    if position is not None and speed is not None and not static:
        known = np.isfinite(position.values) & np.isfinite(speed.values)
        seen = capture.time_s[known], position.values[known], speed.values[known]
        ratio = speed_over_derivative(*seen) if known.sum() > 1 else None
        if ratio is not None and abs(ratio - 1) > 0.1:
            notes.append(
                f"speed is {ratio:.3g} times the derivative of position: one of the two units, "
                "the counts per turn, or a gear between them is wrong"
            )
    return notes


def speed_over_derivative(time_s: Floats, position: Floats, speed: Floats) -> float | None:
    """The factor between ∫speed dt and position, or None where either stands still."""
    travelled = np.r_[0.0, np.cumsum(np.diff(time_s) * (speed[1:] + speed[:-1]) / 2)]
    a, b = position - position.mean(), travelled - travelled.mean()
    power, shared = float(a @ a), float(a @ b)
    if power == 0 or shared == 0 or shared**2 < 0.9 * power * float(b @ b):
        return None
    return shared / power
