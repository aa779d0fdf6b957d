"""Speed and current at every steady level, as measured and as the fit foretells them.

The measured figures are means of readings and rest on no model. The uncertainty of a difference is
that of the means, by the scatter and the colour of the residuals, and that of the parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, Capture
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Diagnostic
from motorid.estimate.signals.measurements import Measured
from motorid.estimate.uncertainty.coloured_mean import variance_growth
from motorid.estimate.uncertainty.intervals import Findings
from motorid.motor.parameters import Motor
from motorid.segment import Segment, SegmentKind

Floats = NDArray[np.float64]
Named = Sequence[tuple[Capture, Sequence[Segment]]]

SURE = 3.0  # standard uncertainties of a difference
FEWEST = 16  # readings of a level
TURNS = 2.0  # that a level must last: slots and brushes make friction swing once a turn, or faster
STEP = 1e-4  # of a search coordinate, for a derivative
HARM = 0.01  # relative difference below which no level is worth a remark


@dataclass(frozen=True)
class Reached:
    """One quantity at one level: ``u`` is the standard uncertainty of measured less foretold."""

    quantity: str
    unit: str
    measured: float
    foretold: float
    u: float

    @property
    def differs(self) -> bool:
        """By more than the uncertainties, and enough to matter."""
        off = abs(self.measured - self.foretold)
        return off > SURE * self.u and off > HARM * abs(self.measured)


@dataclass(frozen=True)
class Level:
    """A steady level of one capture."""

    capture: int
    start_s: float
    end_s: float
    speed: Reached | None = None
    current: Reached | None = None


def levels(found: Findings, records: Sequence[MotorRecord], named: Named) -> list[Level]:
    """Every driven steady level that shows a speed, and lasts long enough to."""
    out = []
    for k, (record, own) in enumerate(zip(records, found.solution.own, strict=True)):
        steady = [s for s in named[k][1] if s.kind is SegmentKind.STEADY]
        if not steady:
            continue
        left = record.departures(found.solution.values, own)
        time = named[k][0].time_s
        for s in steady:
            blocks = [_means(record, m, y, s) for m, y in zip(record.measured, left, strict=True)]
            start_s, end_s = float(time[s.start]), float(time[s.stop - 1])
            speed, current = _speed(found, blocks), _current(found, blocks)
            turned = 0.0 if speed is None else abs(speed.measured) * (end_s - start_s)
            if turned >= TURNS * 2.0 * np.pi:
                out.append(Level(k, start_s, end_s, speed, current))
    return out


def findings(reached: Iterable[Level], motor: Motor, runs: int = 1) -> Iterator[Diagnostic]:
    """One remark on the level that differs most of each quantity."""
    for name in ("speed", "current"):
        off = [
            (abs(one.measured - one.foretold) / one.u, level, one)
            for level in reached
            if (one := getattr(level, name)) is not None and one.differs
        ]
        if not off:
            continue
        times, level, one = max(off, key=lambda row: row[0])
        where = f" in run {level.capture + 1}" if runs > 1 else ""
        yield Diagnostic(
            f"steady_{name}", "warning",
            f"steady level from {level.start_s:.3f} to {level.end_s:.3f} s{where}: the {name} was "
            f"measured as {one.measured:.4g} {one.unit} and is predicted as {one.foretold:.4g} "
            f"{one.unit}, {times:.2g} standard uncertainties apart; friction may depend on the "
            "direction, the speed or the angle, or a reading may be wrong there",
            _moves(one, level, motor),
        )  # fmt: skip


def _moves(one: Reached, level: Level, motor: Motor) -> dict[str, float]:
    """What would make up for the difference: friction for a current, the constant for a speed."""
    off, speed = abs(one.measured - one.foretold), level.speed
    if one.quantity == SPEED:
        return {"K": motor.K * off / abs(one.measured)} if one.measured else {}
    rad_s = abs(speed.measured) if speed is not None else 0.0
    viscous = {"B": motor.K * off / rad_s} if rad_s else {}
    return {"T0": motor.K * off, **viscous}


@dataclass(frozen=True)
class _Means:
    """Of one block over a level: measured, and how far that is from the fit, with its scatter."""

    name: str
    measured: float
    off: float
    u: float


def _means(record: MotorRecord, m: Measured, left: Floats, s: Segment) -> _Means | None:
    first, last = (int(record.timeline.index[k]) for k in (s.start, s.stop - 1))
    inside = (m.keep >= first) & (m.keep <= last)
    n = int(inside.sum())
    if n < FEWEST or m.unsigned:
        return None
    y, r, name = m.values[inside], left[inside], m.block.name
    if name == POSITION:
        time = np.asarray(m.keep[inside] * record.timeline.period_s, dtype=np.float64)
        return _travel(time, y, r, m.block.floor)
    about = r - r.mean()
    scatter = max(float(np.sqrt(np.mean(about**2))), m.block.floor)
    u = scatter * float(np.sqrt(variance_growth(about) / n))
    quarter = max(n // 4, 1)
    drift = float(r[-quarter:].mean() - r[:quarter].mean()) / 2.0  # the level has not settled
    return _Means(name, float(y.mean()), float(r.mean()), float(np.hypot(u, drift)))


def _travel(time: Floats, y: Floats, r: Floats, floor: float) -> _Means:
    """The speed of a position, and of what the fit leaves of it: slopes over the level."""
    t = time - time.mean()
    extent = float(t @ t)
    slope = float(t @ r) / extent
    about = r - r.mean() - slope * t
    scatter = max(float(np.sqrt(np.mean(about**2))), floor)
    return _Means(SPEED, float(t @ y) / extent, slope, scatter * np.sqrt(2.0) / float(np.ptp(time)))


def _speed(found: Findings, blocks: Sequence[_Means | None]) -> Reached | None:
    speed, current = (_of(blocks, name) for name in (SPEED, CURRENT))
    if speed is None:
        return None
    foretold = speed.measured - speed.off
    amperes = current.measured - current.off if current is not None else 0.0
    before = found.motor()
    volts = before.R * amperes + before.K * foretold
    way = float(np.sign(foretold))

    def of(motor: Motor) -> float:
        torque = motor.K * volts - way * motor.R * motor.T0
        return torque / (motor.K**2 + motor.R * motor.B)

    u = float(np.hypot(speed.u, _uncertainty(found, of)))
    return Reached(SPEED, "rad/s", speed.measured, foretold, u)


def _current(found: Findings, blocks: Sequence[_Means | None]) -> Reached | None:
    speed, current = (_of(blocks, name) for name in (SPEED, CURRENT))
    if current is None:
        return None
    rad_s = speed.measured if speed is not None else 0.0

    def of(motor: Motor) -> float:
        return (motor.B * rad_s + float(np.sign(rad_s)) * motor.T0) / motor.K

    u = float(np.hypot(current.u, _uncertainty(found, of) if rad_s else 0.0))
    return Reached(CURRENT, "A", current.measured, current.measured - current.off, u)


def _of(blocks: Sequence[_Means | None], name: str) -> _Means | None:
    return next((b for b in blocks if b is not None and b.name == name), None)


def _uncertainty(found: Findings, of: Callable[[Motor], float]) -> float:
    """Standard uncertainty of a figure of the motor, by all that makes the parameters uncertain."""
    search = found.search
    gradient = np.zeros(len(search))
    for k, unknown in enumerate(found.solution.unknowns):
        step = STEP if unknown.log else STEP * max(abs(float(search[k])), 1e-12)
        moved = [search.copy(), search.copy()]
        moved[0][k] -= step
        moved[1][k] += step
        low, high = (of(found.motor(one)) for one in moved)
        gradient[k] = (high - low) / (2.0 * step)
    statistical, instrument, _ = found.propagate(gradient)
    return float(np.hypot(statistical, instrument))
