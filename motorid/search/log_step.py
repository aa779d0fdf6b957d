"""The first step of a log, for methods that know one step response: nobody logged the program.

A log's grid is finer than its samples. A step is read at the samples, one usual period apart, and
its voltage is the mean from each to the next.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorid.capture.model import CURRENT, POSITION, Capture
from motorid.errors import DataError
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic, Floats
from motorid.estimate.signals.log_sections import part
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.standstill import starts_at_rest
from motorid.motor.batch import Record

ON = 0.3  # of the highest voltage, from which the motor is driven
APART = 0.1  # of the level, by which the voltage is another
FEWEST = 16  # samples of a step


def is_log(record: MotorRecord) -> bool:
    """Nobody knows its program."""
    return record.capture.program is None


def begun_at_rest(
    records: Sequence[MotorRecord], method: str
) -> tuple[list[MotorRecord], list[Diagnostic]]:
    """The records that a search can take, and what is said of the others.

    Raises DataError where none begins at rest.
    """
    fair = [r for r in records if not is_log(r) or starts_at_rest(r.capture, r.driven)]
    if not fair:
        raise DataError(
            f"the method {method} takes motors that begin at rest, and no stretch of this log "
            "does: use the method ml, or begin the import (--start) where the motor rests"
        )
    if len(fair) == len(records):
        return fair, []
    text = (
        f"{len(records) - len(fair)} of {len(records)} stretches of the logs do not begin at rest, "
        f"and the method {method} leaves them out; the method ml takes them"
    )
    return fair, [Diagnostic("begins_in_motion", "warning", text)]


def cut_to_first_step(record: MotorRecord) -> Capture:
    """The log up to the end of its first step."""
    _, stop = _stretch(record)
    samples = int(np.searchsorted(record.timeline.index, stop))
    return part(record.capture, 0, max(samples, FEWEST))


def first_step(record: MotorRecord) -> Record:
    """The first stretch of a log under one voltage, from rest; turned so that it is positive.

    Raises DataError where no voltage stays for long enough, or a current or motion is missing.
    """
    start, stop = _stretch(record)
    period = record.capture.period_s
    fine = record.timeline.period_s
    ticks = np.arange(start * fine, stop * fine, period)
    if len(ticks) < FEWEST:
        raise DataError(
            f"the first step of this log lasts {len(ticks)} samples, and a method that knows one "
            f"step needs {FEWEST} under one voltage: use the method ml"
        )
    flux = np.concatenate([[0.0], np.cumsum(record.sensed.volts) * fine])
    edges = np.append(ticks, ticks[-1] + period) + fine  # interval n ends at tick n
    volts = np.diff(np.interp(edges, np.arange(len(flux)) * fine, flux)) / period
    side = float(np.sign(np.median(volts)))
    measured, lags = {}, {}
    for m in record.measured:
        if m.block.name == EMF:
            continue
        past = 0.0 if m.past is None else m.past
        late = m.channel.delay_s + m.channel.window_s / 2.0
        values = m.values - _offset(record) if m.block.name == CURRENT else m.values
        read = np.interp(ticks, (m.keep + past) * fine - late, values)
        name = "speed" if m.block.name == POSITION else m.block.name
        measured[name] = side * (np.gradient(read, period) if m.block.name == POSITION else read)
        lags[name] = 0.0
    if not {"current", "speed"} <= set(measured):
        raise DataError("a method that knows one step needs a current and a speed or position")
    return Record(period, side * volts, measured, None, lags)


def _offset(record: MotorRecord) -> float:
    starts = {unknown.name: unknown.start for unknown in record.unknowns}
    return float(starts.get(CURRENT_OFFSET.name, 0.0))


def _stretch(record: MotorRecord) -> tuple[int, int]:
    """First interval under the first level, and the end of that."""
    volts: Floats = record.sensed.volts
    highest = float(np.percentile(np.abs(volts), 98))
    on = np.flatnonzero(np.abs(volts) >= ON * highest)
    if not highest or not len(on):
        raise DataError("the motor was never driven in this capture: capture a run with a step")
    width = max(round(record.capture.period_s / record.timeline.period_s), 1)
    start = int(on[0])
    level = float(np.median(volts[start + width : start + (FEWEST // 2) * width]))
    other = np.abs(volts[start + width :] - level) > APART * abs(level)
    lasting = other & np.append(other[1:], True)
    stop = start + width + (int(np.argmax(lasting)) if lasting.any() else len(other))
    return max(start - 1, 0), stop - 1
