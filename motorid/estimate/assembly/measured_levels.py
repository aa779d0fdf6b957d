"""Voltage, current and speed at every steady level by the readings alone, as of a settled motor.

    x(t) = x0 + w t + a exp(-t/T)        i(t) = i0 + c exp(-t/T)

A level that the motor has not reached by its end is followed to where it leads. Only the time
constant T is of the fit: J R'/K², where the slope of the brush drop at the level's current adds to
the resistance R'. A tenth of it counts as its uncertainty, and a third of what the brushes add.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.effects.brush_and_heating import BENT, DROP
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Curve, MeasuredLevel
from motorid.estimate.signals.source.pwm_bridge import ripple
from motorid.estimate.solver.problem import Solution
from motorid.motor.brushes import Brushes
from motorid.motor.parameters import Motor, mechanical_time_constant
from motorid.segment import Segment, SegmentKind

Floats = NDArray[np.float64]
Named = Sequence[tuple[Capture, Sequence[Segment]]]

FEWEST = 32  # readings of a level
TURNS = 2.0  # that a level must last: slots and brushes make friction swing once a turn, or faster
DOUBT, OF_BRUSHES = 0.1, 0.3  # of the time constant, and of the brushes' part in it
FASTEST, SLOWEST = 0.02, 3.0  # time constants over the level's length between which it is followed
LEFT = 0.02  # of the speed: the most that may be left to go at the end
REACH = 2.0  # time constants before the end of a level that belong to it
BLOCKS = 8  # of a level, whose means' scatter holds what repeats with the turn
STUDENT = 1.31  # 95 % factor of the 5 degrees of freedom that they leave, over the normal one


@dataclass(frozen=True)
class _Figure:
    value: float
    u: float
    left: float  # to go, at the end of the level


@dataclass(frozen=True)
class _Approach:
    """How the level is reached: its time constant, and the relative uncertainty of that."""

    constant_s: float
    doubt: float


def measured_levels(
    named: Named, curves: Sequence[Curve], motor: Motor, brushes: Brushes | None
) -> tuple[MeasuredLevel, ...]:
    """Every driven steady stretch that lasts long enough, in the order of the captures."""
    own = {(c.capture, c.channel): c for c in curves}
    out = []
    for k, (capture, segments) in enumerate(named):
        for before, s in zip((None, *segments), segments, strict=False):
            if s.kind is SegmentKind.STEADY and s.stop - s.start >= FEWEST:
                approach = _approach(capture, s, motor, brushes)
                long = _with_approach(capture, before, s, approach.constant_s)
                out.append(_level(k, capture, long, own, approach))
    return tuple(out)


def _with_approach(
    capture: Capture, before: Segment | None, s: Segment, constant_s: float
) -> Segment:
    """The stretch with the end of the acceleration towards it: more turns, and the approach."""
    if before is None or before.kind is not SegmentKind.ACCELERATION or before.stop != s.start:
        return s
    time = capture.time_s
    from_s = max(
        float(time[before.start]) + constant_s, float(time[s.stop - 1]) - REACH * constant_s
    )
    return replace(s, start=min(s.start, int(np.searchsorted(time, from_s))))


def brushes_of(solution: Solution, records: Sequence[MotorRecord]) -> Brushes | None:
    """What the brushes drop, by the first capture whose unknowns have it."""
    for record, own, spread in zip(records, solution.own, solution.own_covariance, strict=True):
        names = [one.name for one in record.instances]
        loss = record.loss
        if loss is None or DROP not in names:
            continue
        k = names.index(DROP)
        variances = (float(spread[k, k]), 0.0, 0.0)
        if BENT in names:
            b = names.index(BENT)
            variances = (variances[0], float(spread[b, b]), float(spread[k, b]))
        ohms, henry = (float(x) for x in record.motor(solution.values)[:2])
        return Brushes(float(own[k]), loss.bend_a(ohms), _swing(record, henry, ohms), variances)
    return None


def _swing(record: MotorRecord, henry: float, ohms: float) -> float:
    """A, of the current to each side within a PWM period at the highest level."""
    parts = [part for part in record.timeline.parts if not part.open]
    if not parts:
        return 0.0
    highest = max(parts, key=lambda part: abs(float(np.median(record.volts[part.slice]))))
    below, above = ripple(record.capture, highest, henry, ohms)
    return 0.5 * (below + above)


def _approach(capture: Capture, s: Segment, motor: Motor, brushes: Brushes | None) -> _Approach:
    channel = capture.get(CURRENT)
    amperes = 0.0
    if channel is not None and np.isfinite(channel.values[s.slice]).any():
        amperes = float(np.nanmean(channel.values[s.slice]))
    more = 0.0 if brushes is None else max(brushes.slope(amperes), 0.0)
    constant = mechanical_time_constant(replace(motor, R=motor.R + more))
    return _Approach(constant, DOUBT + OF_BRUSHES * more / (motor.R + more))


def _level(
    k: int, capture: Capture, s: Segment, own: dict[tuple[int, str], Curve], approach: _Approach
) -> MeasuredLevel:
    time = capture.time_s
    start, end = float(time[s.start]), float(time[s.stop - 1])
    volts, volts_u = _voltage(capture, s)
    speed, problem = _speed(capture, own, k, (start, end), approach)
    current = _current(capture, own.get((k, CURRENT)), (start, end), approach)
    if speed is not None and abs(speed.value) * (end - start) < TURNS * 2.0 * math.pi:
        problem = f"it lasts less than {TURNS:g} turns"
    if speed is not None and abs(speed.left) > LEFT * abs(speed.value):
        problem = "the speed has not settled there"
    return MeasuredLevel(
        k, start, end, volts, volts_u,
        None if speed is None else speed.value, None if speed is None else speed.u,
        None if current is None else current.value, None if current is None else current.u,
        problem,
    )  # fmt: skip


def _stated(channel: Channel) -> bool:
    """Somebody said how well it is calibrated."""
    return not {"gain", "offset"} & set(channel.undeclared)


def _voltage(capture: Capture, s: Segment) -> tuple[float | None, float | None]:
    channel = capture.get(VOLTAGE)
    if channel is None:
        return None, None
    values = channel.values[s.slice]
    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        return None, None
    mean = float(values.mean())
    if not _stated(channel):
        return mean, None
    noise = float(values.std()) / math.sqrt(len(values))
    return mean, math.hypot(mean * channel.gain_uncertainty, channel.offset_uncertainty, noise)


def _speed(
    capture: Capture,
    own: dict[tuple[int, str], Curve],
    k: int,
    span: tuple[float, float],
    approach: _Approach,
) -> tuple[_Figure | None, str]:
    position, speed = own.get((k, POSITION)), own.get((k, SPEED))
    curve = position or speed
    if curve is None:
        return None, ""
    found = _followed(curve, span, approach, slope=position is not None)
    if found is None:
        return None, ""
    instrument = found.value * capture.clock_uncertainty
    channel = capture.get(SPEED)
    if position is None and channel is not None:
        if not _stated(channel):
            return None, "nobody stated the gain and the offset of the speed"
        gain, offset = channel.gain_uncertainty, channel.offset_uncertainty
        instrument = math.hypot(instrument, found.value * gain, offset)
    return _Figure(found.value, math.hypot(found.u, instrument), found.left), ""


def _current(
    capture: Capture, curve: Curve | None, span: tuple[float, float], approach: _Approach
) -> _Figure | None:
    channel = capture.get(CURRENT)
    if curve is None or channel is None or channel.unsigned or not _stated(channel):
        return None
    found = _followed(curve, span, approach, slope=False)
    if found is None:
        return None
    gain = found.value * channel.gain_uncertainty
    u = math.hypot(found.u, gain, channel.offset_uncertainty)
    return _Figure(found.value, u, found.left)


def _followed(
    curve: Curve, span: tuple[float, float], approach: _Approach, *, slope: bool
) -> _Figure | None:
    """The slope or the value that the readings of a stretch lead to."""
    inside = (curve.time_s >= span[0]) & (curve.time_s <= span[1])
    if int(inside.sum()) < FEWEST or not approach.constant_s > 0.0:
        return None
    time, values = curve.time_s[inside] - span[0], curve.measured[inside]
    length = float(np.ptp(time))
    if approach.constant_s < FASTEST * length:  # it has settled within the first of its readings
        return _fit(time, values, None, slope, curve.sigma)
    constant = min(approach.constant_s, SLOWEST * length)
    found = _fit(time, values, constant, slope, curve.sigma)
    around = [
        _fit(time, values, constant * f, slope, curve.sigma)
        for f in (1 - approach.doubt, 1 + approach.doubt)
    ]
    doubt = abs(around[1].value - around[0].value) / 2.0
    return _Figure(found.value, math.hypot(found.u, doubt), found.left)


def _fit(
    time: Floats, values: Floats, constant: float | None, slope: bool, floor: float
) -> _Figure:
    """Least squares; the uncertainty by the scatter of blocks, each an even share of the level."""
    columns = [np.ones_like(time), *([time] if slope else [])]
    wanted = len(columns) - 1
    if constant is not None:
        columns.append(np.exp(-time / constant))
    design = np.column_stack(columns)
    inverse = np.linalg.pinv(design)
    found = inverse @ values
    left = values - design @ found
    blocks = np.array_split(inverse[wanted] * left, BLOCKS)
    scatter = math.sqrt(sum(float(b.sum()) ** 2 for b in blocks))
    scatter *= STUDENT * math.sqrt(BLOCKS / (BLOCKS - design.shape[1]))
    white = floor * math.sqrt(float((inverse[wanted] ** 2).sum()))
    ahead = 0.0
    if constant is not None:
        end = float(np.exp(-time[-1] / constant)) * float(found[-1])
        ahead = -end / constant if slope else end
    return _Figure(float(found[wanted]), math.hypot(scatter, white), ahead)
