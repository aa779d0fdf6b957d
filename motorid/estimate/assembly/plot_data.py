"""What the report shows beside the parameters: curves, steady-state levels, segments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture
from motorid.estimate.diagnosis.facts.steady_levels import Level, Reached
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.repeating_response import is_of_motor
from motorid.estimate.results.estimate import Curve, SegmentRow, SteadyRow
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.dense_products import square
from motorid.estimate.solver.problem import Solution
from motorid.motor.parameters import Motor
from motorid.segment import Segment, SegmentKind

Floats = NDArray[np.float64]

UNITS = {CURRENT: "A", POSITION: "rad", SPEED: "rad/s", EMF: "V"}


def curves(solution: Solution, records: Sequence[MotorRecord]) -> tuple[Curve, ...]:
    """Measured and fitted readings of every block, motion at the motor's shaft."""
    out = []
    for k, (record, own) in enumerate(zip(records, solution.own, strict=True)):
        fitted = record.fitted(solution.values, own)
        left = record.weighed(record.departures(solution.values, own), filtered=False)
        ripple = _ripple(record, own)
        for m, model, r in zip(record.measured, fitted, left, strict=True):
            place = m.keep if m.past is None else m.keep + m.past
            time = np.asarray(place * record.timeline.period_s, dtype=np.float64)
            name, sigma = m.block.name, float(np.sqrt(square(r) / m.block.count))
            sigma = max(sigma, m.block.floor)
            out.append(Curve(k, name, UNITS[name], time, m.values, model, sigma, ripple.get(name)))
    return tuple(out)


def _ripple(record: MotorRecord, own: Floats) -> dict[str, Floats]:
    """What the blocks show of the motor's ripple and cogging; an encoder's error is no motor's."""
    known = record.repeating
    out = dict(known.bend)
    for one, size in zip(record.instances, own.tolist(), strict=True):
        if one in known.slopes and is_of_motor(one):
            for block, course in known.slopes[one].items():
                out[block] = out.get(block, 0.0) + size * course
    return out


def segments(named: Sequence[tuple[Capture, Sequence[Segment]]]) -> tuple[SegmentRow, ...]:
    """Every stretch of every capture, as the segmenter names it."""
    return tuple(
        SegmentRow(k, s.kind.value, float(c.time_s[s.start]), float(c.time_s[s.stop - 1]), s.reason)
        for k, (c, found) in enumerate(named)
        for s in found
        if s.stop > s.start
    )


def steady(
    motor: Motor,
    gears: Sequence[float],
    named: Sequence[tuple[Capture, Sequence[Segment]]],
    reached: Sequence[Level] = (),
) -> tuple[SteadyRow, ...]:
    """Means of every driven steady-state segment, and the model's current at that speed.

    ``reached``: speeds that the fit foretells of them.
    """
    speeds = {(one.capture, one.start_s): one.speed for one in reached}
    return tuple(
        _row(k, capture, s, motor, gear, speeds.get((k, float(capture.time_s[s.start]))))
        for k, ((capture, found), gear) in enumerate(zip(named, gears, strict=True))
        for s in found
        if s.kind is SegmentKind.STEADY and s.stop - s.start > 1
    )


def _row(
    k: int, capture: Capture, s: Segment, motor: Motor, gear: float, reached: Reached | None
) -> SteadyRow:
    time = capture.time_s
    speed = _speed(capture, s)
    fitted = None
    if speed is not None:
        speed *= gear
        fitted = (motor.B * speed + motor.T0 * float(np.sign(speed))) / motor.K
    return SteadyRow(
        k, float(time[s.start]), float(time[s.stop - 1]),
        _mean(capture, VOLTAGE, s), _mean(capture, CURRENT, s), speed, fitted,
        None if reached is None else reached.foretold,
    )  # fmt: skip


def _mean(capture: Capture, name: str, s: Segment) -> float | None:
    channel = capture.get(name)
    if channel is None or not np.isfinite(channel.values[s.slice]).any():
        return None
    return float(np.nanmean(channel.values[s.slice]))


def _speed(capture: Capture, s: Segment) -> float | None:
    position = capture.get(POSITION)
    if position is None:
        return _mean(capture, SPEED, s)
    travelled = position.values[s.stop - 1] - position.values[s.start]
    return float(travelled / (capture.time_s[s.stop - 1] - capture.time_s[s.start]))
