"""Volts, or a command, and a motion, but no current: the whole likelihood, on the scale of R.

With R -> c R, B -> B/c, J -> J/c, T0 -> T0/c a motor turns as before, and so it does where B
passes into K. What shows is JR/(K² + RB), K/(K² + RB) and T0 R/K, and L/R where the readings are
quick. The fit holds R at 1 Ω and B at 0: its K is then (K² + RB)/K, its J/K is JR/K, and its T0/K
is T0 R/K. Where no reading tells L/R, it is a few hundredths of the time constant, as usual.

A balance of the same log (``mechanical_fit``) says where the search begins, and answers where the
likelihood does not.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, HELD, POSITION, SPEED, TORQUE, VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.assembly.assemble import answered
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.multistart import leaves_misfit, settled
from motorid.estimate.fit.parameter_bounds import merged, searched
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.partial import steady_state_table
from motorid.estimate.partial.mechanical_signals import (
    COMMAND,
    drive_of,
    fresh,
    output_of,
    stands_still,
)
from motorid.estimate.partial.unstated_lag import WINDING
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.signals.log_sections import unbroken
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.intervals import Findings

Floats = NDArray[np.float64]
Better = Callable[["Whole"], Estimate]

SCALE = {"R": 1.0, "B": 0.0}
OPTIONAL = ("T0", "offset")  # what may be left out of such a model; the second is of a balance
LEVEL = 90  # percentile of volts and speeds that begin a search without a balance
MOST = 10_000  # rows that are searched: of more, every lag and filter takes minutes
FAR = 0.06  # of the range of a channel, rms, that a first search may leave
SLOWEST = 0.1  # of a record: the time constant that begins it


@dataclass(frozen=True)
class Whole:
    """What the likelihood says on the scale R = 1, B = 0."""

    estimate: Estimate
    records: Sequence[MotorRecord]
    found: Findings
    held: Mapping[str, float]
    beside: float = 0.0  # relative standard uncertainty of JR/(K² + RB): another reading of a speed

    @property
    def filterable(self) -> bool:
        """The motion is a speed of which nobody said that it is not filtered."""
        speeds = [record.capture.get(SPEED) for record in self.records]
        return any(one is not None and not one.states("filter") for one in speeds)

    @property
    def answers(self) -> bool:
        """Time constant and gain are told."""
        standing = (self.estimate.parameters[name].status for name in ("K", "J"))
        return all(status.measured for status in standing)


def suits(captures: Sequence[Capture], without: Sequence[str] = ()) -> bool:
    """Logs that turn, no longer than MOST, whose volts or command is one signed channel, and that
    hold no current.
    """
    if all(map(stands_still, captures)) or sum(map(len, captures)) > MOST:
        return False
    return all(map(_suits, captures)) and set(without) <= set(OPTIONAL)


def _suits(capture: Capture) -> bool:
    drive, output = drive_of(capture.channels), output_of(capture)
    return (
        capture.program is None
        and not steady_state_table.suits([capture])
        and not {CURRENT, TORQUE} & set(capture.channels)
        and drive in (VOLTAGE, COMMAND)
        and not capture.channels[drive].unsigned
        and output is not None
        and output.unit in ("rad", "rad/s")
    )


def whole(
    captures: Sequence[Capture], start: Mapping[str, float] | None, without: Sequence[str]
) -> Whole:
    """The likelier of two readings of a speed whose window nobody stated: of an instant, or the
    mean since the row before. Raises DataError where neither can be fitted.

    ``start``: K, J and T0 of that scale; None: no balance tells.
    """
    held = {**SCALE, **({"T0": 0.0} if "T0" in without else {})}
    taken = _as_read(captures)
    best, beside = _solved(taken, held, start), 0.0
    means = _as_means(taken)
    if means is not None:
        other = _solved(means, held, start)
        if other.solution.objective < best.solution.objective:
            best, other = other, best
        beside = _apart(best.solution, other.solution)
    found = _told(best, beside)
    if found.answers and not found.estimate.parameters["L"].status.measured:
        return _told(_with_usual(best), math.hypot(beside, WINDING))
    return found


@dataclass(frozen=True)
class _Fitted:
    """Records at their most likely parameters."""

    records: Sequence[MotorRecord]
    solution: Solution
    held: Mapping[str, float]


def _solved(
    captures: Sequence[Capture], held: Mapping[str, float], known: Mapping[str, float] | None
) -> _Fitted:
    """Raises DataError where a first search, of white noise alone, leaves what no delay explains:
    what else could would be looked for through every lag and filter.
    """
    start = known or _guessed(captures)
    begin = {**start, "L": WINDING * _constant(start), **held}
    free = searched(held)
    rough = [MotorRecord(capture, free, held) for capture in captures]
    if leaves_misfit(settled(rough, free, begin), rough, FAR):
        raise DataError("volts and motion do not follow one another as those of a motor")
    return _Fitted(*solved(captures, held, (), begin), held)


def _told(fitted: _Fitted, beside: float) -> Whole:
    captures = [record.capture for record in fitted.records]
    told = answered(captures, fitted.records, fitted.solution, fitted.held, ())
    return Whole(*told, fitted.held, beside)


def _with_usual(free: _Fitted) -> _Fitted:
    """With a winding as slow as usual, where no reading tells it from a delay."""
    values = merged(free.held, free.solution)
    held = {**free.held, "L": WINDING * _constant(values)}
    return _solved([record.capture for record in free.records], held, values)


def _constant(values: Mapping[str, float]) -> float:
    return values["J"] / values["K"] ** 2


def _apart(best: Solution, other: Solution) -> float:
    """By which share, rms, another reading that is as likely moves the time constant."""
    less = float(np.exp(min(best.objective - other.objective, 0.0)))
    share = less / (1.0 + less)
    constants = [_constant(merged({}, one)) for one in (best, other)]
    return float(np.sqrt(share)) * abs(constants[1] / constants[0] - 1.0)


def _as_read(captures: Sequence[Capture]) -> list[Capture]:
    """With the drive as the voltage of the terminals."""
    out = []
    for capture in unbroken(captures):
        name = drive_of(capture.channels) or VOLTAGE
        others = {n: c for n, c in capture.channels.items() if n not in (VOLTAGE, COMMAND)}
        volts = replace(capture.channels[name], name=VOLTAGE, unit="V", sense="terminals")
        out.append(_fresh(replace(capture, channels={VOLTAGE: volts, **others})))
    return out


def _fresh(capture: Capture) -> Capture:
    """Without rows that repeat a reading of the motion."""
    output = output_of(capture)
    rows = np.arange(len(capture))
    if output is None:
        return capture
    kept = fresh(rows, output, capture.provenance.get(HELD, {}))
    if len(kept) in (0, 1, len(rows)):
        return capture
    return capture.rows(slice(int(kept[0]), None, int(kept[1] - kept[0])), ())


def _as_means(captures: Sequence[Capture]) -> list[Capture] | None:
    """With speeds that are means since the row before; None: somebody stated what they are."""
    out = []
    for capture in captures:
        speed = capture.get(SPEED)
        if speed is None or speed.states("aperture") or speed.window_s:
            return None
        period = float(np.median(np.diff(capture.time_s)))
        mean = replace(speed, kind="mean", aperture_s=period)
        out.append(replace(capture, channels={**capture.channels, SPEED: mean}))
    return out


def _guessed(captures: Sequence[Capture]) -> dict[str, float]:
    """A motor that such volts turn at such speeds."""
    volts = max(_high(capture.channels[VOLTAGE].values) for capture in captures)
    speed = max(_high(speeds_of(capture)) for capture in captures)
    length = max(float(np.ptp(capture.time_s)) for capture in captures)
    K = volts / speed if speed else volts
    return {"K": K, "J": SLOWEST * length * K**2, "T0": SLOWEST * volts * K}


def _high(values: Floats) -> float:
    return float(np.nanpercentile(np.abs(values), LEVEL))


def speeds_of(capture: Capture) -> Floats:
    """(n,), of the motor, as read or as its position changes."""
    speed, gear = capture.get(SPEED), capture.wiring.gear_ratio or 1.0
    if speed is not None:
        return gear * speed.values
    return np.asarray(gear * np.gradient(capture.channels[POSITION].values, capture.time_s))
