"""Captures as a problem for the searches: batch records, scales and bounds.

The batch response is simpler than the likelihood's: a speed or position is taken as an instant at
the middle of its aperture, a current ends at once when the bridge opens, and PWM ripple is not
modelled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import CURRENT, POSITION
from motorid.errors import DataError
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS, Floats
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.signals.standstill import starts_at_rest
from motorid.motor.batch import FRICTION, LINEAR, Record
from motorid.search import log_step
from motorid.search.bounds import Box
from motorid.search.objective import peaks
from motorid.search.problem import Problem

SPAN = 10.0  # bounds of R, L, K, J: so many times the closed form's values, either way
FRICTION_SPAN = 1e-3, 3.0  # bounds of B and T0, in units that would explain the whole torque
NOTHING = 1e-3  # an inductance left out: L/R in sample periods


def problem(
    records: Sequence[MotorRecord], start: Mapping[str, float], free: Sequence[str]
) -> Problem:
    """All records under the model with Coulomb friction; ``start`` holds all six, SI.

    Raises DataError for a record that does not begin at rest.
    """
    batch = tuple(batch_record(record) for record in records)
    series = float(np.mean([record.sensed.series_ohm for record in records]))
    return Problem(
        FRICTION,
        batch,
        box(records, start, free),
        peaks(batch),
        start=np.array([start[name] for name in free]),
        given={name: start[name] for name in PARAMETERS if name not in free},
        series_ohm=series,
    )


def step_problem(record: MotorRecord, start: Mapping[str, float]) -> Problem:
    """The first driven part alone, under the linear model: for methods that know one step.

    Coulomb friction is outside that model and goes into B. Raises DataError without such a part.
    """
    if log_step.is_log(record):
        return _problem_of(record, log_step.first_step(record), start)
    driven = [part for part in record.timeline.parts if not part.open]
    if not driven:
        raise DataError("the motor was never driven in this capture: capture a run with a step")
    part = driven[0]
    whole = batch_record(record)
    begin, end = max(part.start - 1, 0), part.stop - 1
    cut = {name: y[begin:end] for name, y in whole.measured.items()}
    if "speed" not in cut:
        cut["speed"] = np.gradient(cut.pop("position"), whole.period_s)
    cut = {name: _whole(cut[name]) for name in ("current", "speed")}
    motion = max((whole.lag_s or {}).values(), default=0.0)  # the one channel that moves
    middle = whole.current_delay_s + whole.current_aperture_s / 2
    lags = {"current": min(middle, whole.period_s), "speed": motion}
    step = Record(whole.period_s, whole.input[begin:end], cut, None, lags)
    return _problem_of(record, step, start)


def _problem_of(record: MotorRecord, step: Record, start: Mapping[str, float]) -> Problem:
    names = LINEAR.parameters
    return Problem(
        LINEAR,
        (step,),
        box([record], start, names),
        peaks((step,)),
        start=np.array([start[name] for name in names]),
        series_ohm=record.sensed.series_ohm,
    )


def batch_record(record: MotorRecord) -> Record:
    """One capture on its grid, offsets at rest removed. Raises DataError if it begins in motion."""
    if not starts_at_rest(record.capture, record.driven):
        raise DataError("the search methods need captures that begin at rest: use the method ml")
    starts = {unknown.name: unknown.start for unknown in record.unknowns}
    offsets = {
        CURRENT: starts.get(CURRENT_OFFSET.name, 0.0),
        POSITION: starts.get("position_origin", 0.0),
    }
    period = record.timeline.period_s
    measured, lags = {}, {}
    aperture = current_delay = 0.0
    for m in record.measured:
        if m.block.name == EMF:
            continue
        if m.unsigned:
            raise DataError("the search methods need a signed current: use the method ml")
        grid = np.full(record.timeline.count, np.nan)
        grid[m.keep] = m.values - offsets.get(m.block.name, 0.0)
        delay = m.channel.delay_s
        if m.block.name == CURRENT:
            whole, current_delay = divmod(delay, period)
            aperture = m.channel.window_s
        else:
            whole, lags[m.block.name] = divmod(delay + m.channel.window_s / 2, period)
        measured[m.block.name] = _earlier(grid, int(whole))
    # Interval n of the timeline ends at its tick n; a batch input is held from tick n on.
    volts = np.append(record.sensed.volts[1:], record.sensed.volts[-1])
    is_open = ~np.append(record.driven[1:], record.driven[-1])
    return Record(period, volts, measured, is_open, lags, aperture, current_delay)


def _earlier(grid: Floats, samples: int) -> Floats:
    return np.append(grid[samples:], np.full(samples, np.nan))


def _whole(y: Floats) -> Floats:
    """Missing readings filled from their neighbours."""
    known = np.flatnonzero(np.isfinite(y))
    if not len(known):
        raise DataError("the first driven part of this capture holds no readings")
    return np.interp(np.arange(len(y)), known, y[known])


def box(records: Sequence[MotorRecord], start: Mapping[str, float], free: Sequence[str]) -> Box:
    """Bounds in SI, searched by their logarithms, about the closed form's ``start``."""
    torque, speed = 0.0, 0.0
    for record in records:
        speed = max(speed, float(np.abs(record.sensed.volts).max()) / start["K"])
        for m in record.measured:
            if m.block.name == CURRENT:
                running = np.abs(m.values[record.driven[m.keep]])
                torque = max(torque, start["K"] * float(np.median(running)))
    if not (torque > 0 and speed > 0):
        raise DataError("the motor was never driven in these captures: capture a run with a step")
    whole = {"B": torque / speed, "T0": torque}
    low, high = FRICTION_SPAN
    bounds = {
        name: (low * whole[name], high * whole[name])
        if name in whole
        else (start[name] / SPAN, start[name] * SPAN)
        for name in free
    }
    lows, highs = np.array(list(bounds.values())).T
    return Box(tuple(free), lows, highs, log=True)


def filled(start: Mapping[str, float], period_s: float) -> dict[str, float]:
    """``start`` with a left-out inductance small enough not to show."""
    values = dict(start)
    if not values["L"]:
        values["L"] = NOTHING * values["R"] * period_s
    return values


def inside(problem_: Problem) -> Problem:
    """The problem with its start pulled inside its bounds."""
    if problem_.start is None:
        return problem_
    edge = 1e-3 * (problem_.box.high - problem_.box.low)
    low, high = problem_.box.low + edge, problem_.box.high - edge
    return replace(problem_, start=np.clip(problem_.start, low, high))
