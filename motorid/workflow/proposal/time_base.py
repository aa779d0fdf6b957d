"""Which column, or arithmetic of rows, is the time; a row's number never counts as seconds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.mapping import Formula
from motorid.capture.units import TIME, units_of
from motorid.errors import UsageError
from motorid.workflow.proposal.naming import words
from motorid.workflow.proposal.question import Answer, Known, Question
from motorid.workflow.proposal.seen import Seen, Table
from motorid.workflow.proposal.vocabulary import INDEX

Floats = NDArray[np.float64]
# names of numbers that an instrument writes beside its readings: their words, without blanks
INTERVALS = (
    *("increment", "tinc", "xinc", "xincrement", "sampleinterval", "samplinginterval"),
    *("samplingperiod", "sampleperiod", "hinterval", "deltat", "deltax", "ts", "wfincrement"),
    *("interval", "dt"),
)
RATES = ("samplerate", "samplingrate", "samplingfrequency", "samplefrequency", "fs")
STARTS = ("start", "t", "xstart", "xoffset", "starttime", "wfstartoffset", "firstpoint")
PERIODS_S, PERIOD_COST = (4e-6, 0.25), 8.0  # usual ones of a motor's log; what others cost
SLOW_S, SLOW_COST = 2.0, 4.0  # of steps that are all one: a sweep of steady levels has such periods
SPANS_S, SPAN_COST = (0.03, 7200.0), 5.0
COST = {"s": 0.0, "ms": 1.0, "us": 2.0}  # of a unit that nobody states
NEAR = 0.02  # relative difference of two intervals that are one
COARSE = 6.0  # cost of seconds where stamps are whole and more than one apart
SECONDS = {unit: size for unit, (_, size) in units_of(TIME).items()}


@dataclass(frozen=True)
class TimeBase:
    """``expression`` "": the rows have no time. ``costs``: of each unit that may be meant."""

    expression: str
    values: Floats
    costs: Mapping[str, float]
    why: str
    column: str = ""  # the one that it is, or counts with
    question: Question | None = None


def of_table(table: Table, known: Known) -> TimeBase:
    """The time of the rows."""
    if TIME in known.columns:
        return _stated(table, known)
    clock = _instrument(table)
    ascending = [c for c in table.columns if not c.unread and c.ascending]
    stamps = _as_stated(clock, ascending) if clock is not None else None
    if stamps is not None:
        return stamps
    named = [c for c in table.columns if not c.unread and c.meaning.quantity == TIME]
    named = sorted(named, key=lambda c: (not c.ascending, -c.meaning.strength))
    if named and (named[0].ascending or named[0].meaning.unit):
        return _of_column(named[0], clock)
    if clock is not None:
        return clock
    indexes = [c for c in ascending if c.counts_rows]
    even = [c for c in ascending if c.even and not c.counts_rows]
    nameless = [c for c in even if c.meaning.quantity in ("", INDEX)]
    first = table.columns[0]
    if nameless and (nameless[0] is first or len(nameless) == 1):
        return _of_column(first, None)
    return _ask_period(table, indexes[0] if indexes else None)


def _as_stated(clock: TimeBase, ascending: Sequence[Seen]) -> TimeBase | None:
    """A column of stamps, none of them twice, at the interval that the instrument states."""
    interval = float(np.median(np.diff(clock.values))) if len(clock.values) > 1 else 0.0
    for column in ascending:
        agrees = abs(column.period - interval) < NEAR * interval
        if agrees and (column.steps > 0.0).all():
            why = "its steps are the interval that the instrument states"
            return TimeBase(column.name, column.values, {"s": 0.0}, why, column.name)
    return None


def _stated(table: Table, known: Known) -> TimeBase:
    expression = known.columns[TIME]
    if not expression:
        return TimeBase("", np.zeros(0), {}, "rows are steady points, as stated")
    unit = known.units.get(TIME, "")
    column = table.named(expression)
    if column is not None and not unit:
        return _of_column(column, None, chosen=True)
    values = column.values if column is not None else evaluated(table, expression)
    name = column.name if column is not None else ""
    return TimeBase(expression, values, {unit or "s": 0.0}, "as stated", name)


def formula_of(table: Table, expression: str) -> Formula:
    """Arithmetic over a table's columns. Raises UsageError."""
    return Formula(expression, table.source.names, table.source.constants)


def evaluated(table: Table, expression: str) -> Floats:
    """Arithmetic over the columns that were looked at, (rows,). Raises UsageError."""
    formula = formula_of(table, expression)
    values: dict[str, Floats] = {}
    for name in formula.columns:
        column = table.named(name)
        if column is not None:
            values[name] = column.values
        elif name in table.source.constants:
            values[name] = np.array([table.source.constants[name]])
        elif name != "row":
            raise UsageError(f"{name!r} was not looked at: give a --map for each quantity")
    return formula.evaluate(values, table.rows)


def _of_column(column: Seen, clock: TimeBase | None, *, chosen: bool = False) -> TimeBase:
    """A column of stamps; an instrument's own interval replaces stamps that repeat."""
    stated = column.meaning.unit
    if clock is not None and not (column.ascending and (column.steps > 0.0).all()):
        return clock
    if stated in SECONDS:
        costs = dict.fromkeys(COST, 16.0) | {stated: 0.0}
        return TimeBase(column.name, column.values, costs, "by name and unit", column.name)
    if column.counts_rows and not chosen:
        return _ask_index(column)
    period, span = column.period, float(np.ptp(column.finite)) if len(column.finite) else 0.0
    costs = dict(COST)
    for unit, scale in SECONDS.items():
        if unit not in costs:
            continue
        inside = PERIODS_S[0] <= period * scale <= PERIODS_S[1]
        slow = PERIODS_S[1] < period * scale <= SLOW_S and bool((column.steps == period).all())
        costs[unit] += 0.0 if inside else SLOW_COST if slow else PERIOD_COST
        costs[unit] += 0.0 if SPANS_S[0] <= span * scale <= SPANS_S[1] else SPAN_COST
    if column.whole and period > 1.0:
        costs["s"] += COARSE
    how = "by name" if column.meaning.quantity == TIME else "ascends evenly"
    return TimeBase(column.name, column.values, costs, how, column.name)


def _ask_index(column: Seen) -> TimeBase:
    name = column.name
    question = Question(
        f"{name} rises by 1 a row and has no unit: is it a time, or does it number the rows?",
        (
            Answer("milliseconds", Known({TIME: name}, {TIME: "ms"}), f"--map time={name}:ms"),
            Answer("seconds", Known({TIME: name}, {TIME: "s"}), f"--map time={name}:s"),
            Answer("microseconds", Known({TIME: name}, {TIME: "us"}), f"--map time={name}:us"),
        ),
        "it numbers the rows: seconds from one to the next",
        TIME,
        "row*{}",
        "s",
    )
    return TimeBase(name, column.values, {"ms": 0.0, "s": 0.0}, "unsure", name, question)


def _ask_period(table: Table, index: Seen | None) -> TimeBase:
    numbers = f"{index.name} numbers the rows" if index is not None else "no column is a time"
    question = Question(
        f"{numbers}: how many seconds lie between one row and the next?",
        (Answer("rows are steady points without a time", Known({TIME: ""}), ""),),
        "seconds between rows",
        TIME,
        "row*{}",
        "s",
    )
    name = index.name if index is not None else ""
    return TimeBase("", np.arange(float(table.rows)), {}, numbers, name, question)


def _instrument(table: Table) -> TimeBase | None:
    """Start and increment, or a rate, that an instrument states beside its readings."""
    named = {"".join(w for w in words(n) if not w.isdigit()): n for n in table.source.constants}
    interval = next((named[n] for n in INTERVALS if n in named), "")
    rate = next((named[n] for n in RATES if n in named), "")
    start = next((named[n] for n in STARTS if n in named), "")
    constants = table.source.constants
    if not (interval and constants[interval] > 0) and not (rate and constants[rate] > 0):
        return None
    step = f"row*{interval}" if interval and constants[interval] > 0 else f"row/{rate}"
    expression = f"{start}+{step}" if start else step
    index = next((c for c in table.columns if c.counts_rows), None)
    return TimeBase(
        expression, evaluated(table, expression), {"s": 0.0},
        f"{interval or rate} of the instrument", index.name if index is not None else "",
    )  # fmt: skip
