"""[12]'s closed forms on captures: ``steady-state`` with the coast-down, and ``acceleration``.

Levels, rises and coasts are the segmenter's. L, which neither route gives, is the closed form's of
the default method.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture
from motorid.errors import DataError
from motorid.estimate.assembly import plot_data
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Floats
from motorid.motor.parameters import Motor
from motorid.search import closed_forms
from motorid.search.closed_forms import Levels
from motorid.search.problem import Solution
from motorid.segment import Segment, SegmentKind, segment

TITLES = {
    "steady-state": "Equations 11 over all steady levels and 12 over coasts",
    "acceleration": "Acceleration method",
}
AVERAGE = 0.01  # of a stretch: the span over which a position's slope is its speed


def solve(
    captures: Sequence[Capture],
    records: Sequence[MotorRecord],
    start: Mapping[str, float],
    method: str,
) -> Solution:
    """All six parameters (SI). Raises DataError where the segments that it needs are missing."""
    begin = time.perf_counter()
    named = [(capture, segment(capture)) for capture in captures]
    at = _levels(named, records, Motor.of(start))
    found = closed_forms.steady_state(at)
    if method == "acceleration":
        found |= closed_forms.two_levels(at, found["R"])
        found["J"] = _mean(_rises(named, records, found), "acceleration from near rest")
    else:
        found["J"] = _mean(_coasts(named, records, found), "coast with the bridge open")
    found["R"] -= float(np.mean([record.sensed.series_ohm for record in records]))
    values = {**start, **found}
    wrong = [name for name in ("R", "K", "J") if not values[name] > 0]
    if wrong:
        raise DataError(f"{TITLES[method]}: {wrong[0]} comes out negative; use the method ml")
    seconds = time.perf_counter() - begin
    return Solution(method, values, np.nan, 1, seconds, "closed form", 0, np.empty((0, 2)))


def _levels(
    named: Sequence[tuple[Capture, Sequence[Segment]]], records: Sequence[MotorRecord], motor: Motor
) -> Levels:
    rows = plot_data.steady(motor, [record.gear for record in records], named)
    full = [
        (row.voltage_v, row.current_a, row.speed_rad_s)
        for row in rows
        if row.voltage_v is not None and row.current_a is not None and row.speed_rad_s is not None
    ]
    # friction changes its sign with the speed: a level that turns back is one seen in a mirror
    mirrored = np.array([[np.sign(w) * x for x in (v, i, w)] for v, i, w in full]).reshape(-1, 3)
    return Levels(*mirrored.T)


def _stretches(
    named: Sequence[tuple[Capture, Sequence[Segment]]],
    records: Sequence[MotorRecord],
    kind: SegmentKind,
) -> Iterator[tuple[Floats, Floats, float]]:
    """Current, speed and period of every such segment, turned so that the speed is positive."""
    for (capture, segments), record in zip(named, records, strict=True):
        current = capture.get(CURRENT)
        for part in segments:
            if part.kind is not kind or part.stop - part.start < 2 / AVERAGE or current is None:
                continue
            speed = record.gear * _speed(capture, part)
            sign = float(np.sign(np.nanmean(speed)))
            yield sign * current.values[part.slice], sign * speed, capture.period_s


def _speed(capture: Capture, part: Segment) -> Floats:
    position = capture.get(POSITION)
    if position is None:
        return capture.channels[SPEED].values[part.slice]
    angle = position.values[part.slice]
    half = max(int(AVERAGE * len(angle)) // 2, 1)
    index = np.arange(len(angle))
    ahead, behind = np.minimum(index + half, len(angle) - 1), np.maximum(index - half, 0)
    return np.asarray((angle[ahead] - angle[behind]) / ((ahead - behind) * capture.period_s))


def _rises(
    named: Sequence[tuple[Capture, Sequence[Segment]]],
    records: Sequence[MotorRecord],
    friction: Mapping[str, float],
) -> Iterator[float]:
    for current, speed, period in _stretches(named, records, SegmentKind.ACCELERATION):
        top = float(speed.max())
        if speed[0] < closed_forms.INTERVAL[0] * top:
            yield closed_forms.rise_inertia(current, speed, period, friction, top)


def _coasts(
    named: Sequence[tuple[Capture, Sequence[Segment]]],
    records: Sequence[MotorRecord],
    friction: Mapping[str, float],
) -> Iterator[float]:
    for _, speed, period in _stretches(named, records, SegmentKind.COAST):
        yield closed_forms.coast_inertia(speed, period, friction["B"], friction["T0"])


def _mean(values: Iterator[float], needed: str) -> float:
    found = list(values)
    if not found:
        raise DataError(f"these captures hold no {needed}: capture a run that does")
    return float(np.mean(found))
