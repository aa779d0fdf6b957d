"""How the readings of a log came, where nobody says so and a choice between few ways decides it.

A speed that counts edges since the last reading is the mean over that time, and so is a current
behind an integrating converter. A voltage that was read when it jumped, or jumped between two
readings, is no course that joins or holds them: then the moment of each jump is an unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, Capture
from motorid.estimate.effects.unstated import default
from motorid.estimate.fit.alternating_fit import vanished
from motorid.estimate.fit.logs.log_unknowns import (
    Fit,
    as_rival,
    like,
    readings,
    widened,
    with_rivals_of,
)
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.intersample_voltage import (
    LOOSE,
    LOOSE_SOURCE,
    UNTIMED,
    Shape,
    source_ohms_of,
)
from motorid.estimate.signals.measurements import motion
from motorid.estimate.solver.autoregression import inflation
from motorid.estimate.solver.problem import Solution

Floats = NDArray[np.float64]
Search = Callable[[Sequence[Capture], Shape, Fit], Fit]  # readings, a shape, where to begin

TURNING = {"K", "B", "J", "T0"}  # one of them is searched where a rotor turns
STRONG = 2.0  # times Schwarz's price, of a current of means: it is much like an inductance
AFTER = 3  # samples after a jump in which its moment shows
COLOURED = 4.0  # times white noise, at some frequency: a search may have ended short of a cause
LARGER = 1.5  # variance there, of that elsewhere, from which the moments are asked for


def taken(
    records: list[MotorRecord],
    solution: Solution,
    free: Sequence[str],
    start: Mapping[str, float],
    fixed: Mapping[str, float],
) -> Fit:
    """The likeliest way in which these readings came; the others are its rivals."""

    def again(captures: Sequence[Capture], shape: Shape, near: Fit) -> Fit:
        others = [MotorRecord(capture, free, fixed, shape) for capture in captures]
        return others, settled(others, free, merged(start, near[1]))

    turns = any(motion(record.capture) for record in records) and not TURNING.isdisjoint(free)
    if not turns:  # without a motion the current is all that tells of its means
        return _loosened((records, solution), again)
    best = _averaged((records, solution), SPEED, again)
    loose = _loosened(best, again)
    if loose is not best:  # what jumps left may have decided it
        best = _averaged(loose, SPEED, again)
    return _averaged(best, CURRENT, again)


def reconsidered(
    before: Fit, free: Sequence[str], start: Mapping[str, float], fixed: Mapping[str, float]
) -> Fit:
    """The same of a speed, once lags and low-passes are found, which were taken for it before."""

    def again(captures: Sequence[Capture], shape: Shape, near: Fit) -> Fit:
        others = like(near, [MotorRecord(capture, free, fixed, shape) for capture in captures])
        known = merged(start, near[1])
        return others, widened(others, free, known, settled(others, free, known))

    return _averaged(before, SPEED, again)


def _averaged(before: Fit, name: str, again: Search) -> Fit:
    """The likelier of readings of an instant, and of means since the reading before."""
    captures = [otherwise(record, name) for record in before[0]]
    if not any(captures):
        return before
    changed = [c or record.capture for c, record in zip(captures, before[0], strict=True)]
    other = again(changed, before[0][0].shape, before)
    others = other[0]
    gain = before[1].fair - other[1].fair
    if name == CURRENT and vanished(other[1], others):
        return before  # the mean has taken the winding's time constant for its own
    if gain <= (STRONG * np.log(readings(others)) if name == CURRENT else 0.0):
        best, rival = before, other
    else:
        best, rival = with_rivals_of(before, other), before
    for k, record in enumerate(best[0]):
        record.rivals = (*record.rivals, as_rival(rival, best, k))
    return best


def otherwise(record: MotorRecord, name: str) -> Capture | None:
    """The capture with a channel of means over the usual period in place of instants, or the
    reverse; None: somebody states which, or it is no log.
    """
    measured, period_s = record.block(name), default.period_s(record)
    if measured is None or not default.unstated(record, measured.channel, "aperture"):
        return None
    channel = record.capture.channels[name]
    if channel.window_s:
        channel = replace(channel, kind="instant", aperture_s=0.0)
    else:
        channel = replace(channel, kind="mean", aperture_s=period_s)
    return replace(record.capture, channels={**record.capture.channels, name: channel})


def _loosened(before: Fit, again: Search) -> Fit:
    """With the moment of every jump as an unknown, where the residuals ask for it, or where it
    explains all that they leave.
    """
    records, solution = before
    if not any(_jumps(record) for record in records):
        return before
    asked = any(
        _asks(r, solution.values, own) for r, own in zip(records, solution.own, strict=True)
    )
    if not asked and inflation(solution) < COLOURED:
        return before
    captures = [record.capture for record in records]
    sourced = any(source_ohms_of(capture) for capture in captures)
    shapes = (LOOSE, LOOSE_SOURCE) if sourced else (LOOSE,)
    price = float(np.log(readings(records)))  # of each unknown (Schwarz)

    def total(fit: Fit) -> float:
        return fit[1].fair + price * sum(len(record.unknowns) for record in fit[0])

    found = min((again(captures, shape, before) for shape in shapes), key=total)
    if total(found) > total(before):
        return before
    return found if asked or inflation(found[1]) < COLOURED else before


def _jumps(record: MotorRecord) -> bool:
    """Its voltage jumps, at moments that are no unknowns yet; stated means have no other shape."""
    waveform = record.sensed.waveform
    if waveform is None or waveform.shape in UNTIMED or waveform.window_s:
        return False
    return len(waveform.steps_off) > 0


def _asks(record: MotorRecord, values: Floats, own: Floats) -> bool:
    """After jumps of the voltage the current is left far larger residuals than elsewhere."""
    waveform, current = record.sensed.waveform, record.block(CURRENT)
    if waveform is None or current is None or not _jumps(record):
        return False
    jumped = waveform.time_s[waveform.steps_off]
    left = record.departures(values, own)[record.measured.index(current)]
    at_s = current.keep * record.timeline.period_s
    since = at_s - jumped[np.maximum(np.searchsorted(jumped, at_s, side="right") - 1, 0)]
    near = (since >= 0.0) & (since < AFTER * waveform.period_s)
    if near.all() or not near.any():
        return False
    return bool(np.mean(left[near] ** 2) > LARGER * np.mean(left[~near] ** 2))
