"""A short weak pulse of the bridge, and what it showed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.board import Board, Fields
from motorid.acquire.drive import drive, load, tripped
from motorid.acquire.interrupt import Asked
from motorid.acquire.plan import wire_program
from motorid.acquire.signs import Sign, seen
from motorid.acquire.timeline import Timeline
from motorid.capture.model import CURRENT, POSITION, VOLTAGE
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Rig, settling_s
from motorid.wire.codec import mask_channels, name_of
from motorid.wire.enums import Fault

MOVED = 4  # encoder counts, more than an edge's flicker
CLEAR = 5.0  # standard deviations that tell a reading from noise
FEWEST = 32  # samples of a pulse that show a speed
BEFORE_S, AFTER_S = 0.01, 0.02


@dataclass(frozen=True)
class Pulse:
    """What a pulse showed. Currents and volts are means while driving, less those before.

    Of one that ends with a brake, means while braking.
    """

    duty: float
    volts: float  # applied: duty times supply
    counts: int  # encoder, until the end of the run
    current_a: float | None
    current_noise_a: float
    peak_a: float
    saturated: bool
    voltage_v: float | None
    coast_v: float | None = None  # of the open terminals, in the last half; None: not open
    counts_per_s: float | None = None  # of the encoder, at the end of the stretch that is shown

    @property
    def draws(self) -> bool:
        """Whether current clearly flowed."""
        return self.current_a is not None and abs(self.current_a) > CLEAR * self.current_noise_a


def weak_pulse(
    board: Board,
    rig: Rig,
    config: Fields,
    zero: Fields,
    stop: Asked,
    duty: float,
    supply_v: float,
    braking: bool = False,
) -> Pulse | None:
    """One pulse, and what it showed while driving, or ``braking`` after it; None: stopped."""
    drive_s = min(max(3 * settling_s(rig.nameplate) / 8, 0.06), 0.3)
    steps = (
        board.rest_step(BEFORE_S),
        Step(StepKind.DRIVE_DUTY, drive_s, duty, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.BRAKE, AFTER_S) if braking else board.rest_step(AFTER_S),
    )
    period = config["sample_period_ticks"]
    wire = wire_program(Program(steps), board.identity, period)
    load(board, wire)
    timeline = Timeline(period, wire.ticks // period, mask_channels(config["channels"]))
    before = board.position()
    reason = drive(board, wire, config, stop, timeline.add)
    if stop.requested:
        return None
    if reason.startswith("fault"):
        text = f"in the first weak pulse ({duty:.0%} duty) {tripped(reason, board.trip)}"
        over = reason == f"fault: {name_of(Fault, Fault.OVER_CURRENT)}"
        raise seen(Sign.SHORTED, text) if over else RigError(text)
    counts = board.position() - before
    arrays = timeline.arrays()
    if not len(arrays.ticks):
        raise RigError("the board sent no samples of the first pulse: its firmware is at fault")
    before_it, shown = (2, wire.steps[2]) if braking else (1, wire.steps[1])
    first = int(arrays.ticks[0]) + sum(step["ticks"] for step in wire.steps[:before_it])
    part = (arrays.ticks > first) & (arrays.ticks <= first + shown["ticks"])
    if not part.any():
        raise RigError("every sample of the first pulse was lost: check the cable")
    found = _measure(board, arrays.columns, part, zero, duty, supply_v, counts)
    period_s = period / board.identity["clock_hz"]
    coast = (
        None
        if braking or not board.opens
        else _after(board, arrays, first + shown["ticks"], wire, zero)
    )
    found = replace(found, coast_v=coast)
    return replace(found, counts_per_s=_speed(arrays.columns.get(POSITION), part, period_s))


def _measure(
    board: Board,
    columns: Any,
    driven: NDArray[np.bool_],
    zero: Fields,
    duty: float,
    supply_v: float,
    counts: int,
) -> Pulse:
    current = _values(board, columns, CURRENT, zero["current_offset"])
    voltage = _values(board, columns, VOLTAGE, zero["voltage_offset"])
    noise, peak, saturated = 0.0, 0.0, False
    if current is not None:
        fact = board.descriptors[CURRENT]
        raw = columns[CURRENT][driven]
        count = abs(fact["scale"])
        noise = count * math.hypot(zero["current_noise"], 0.3) / math.sqrt(driven.sum())
        peak = float(np.max(np.abs(current[driven])))
        saturated = bool(np.any((raw <= fact["raw_min"]) | (raw >= fact["raw_max"])))
    return Pulse(
        duty=duty,
        volts=duty * supply_v,
        counts=(counts + (1 << 31)) % (1 << 32) - (1 << 31),
        current_a=None if current is None else float(np.mean(current[driven])),
        current_noise_a=noise,
        peak_a=peak,
        saturated=saturated,
        voltage_v=None if voltage is None else float(np.mean(voltage[driven])),
    )


def _after(board: Board, arrays: Any, end: int, wire: Any, zero: Fields) -> float | None:
    """V of the open terminals once the current has died away: what a turning rotor induces."""
    fact = board.descriptors.get(VOLTAGE)
    part = arrays.ticks > end + wire.steps[2]["ticks"] // 2
    voltage = _values(board, arrays.columns, VOLTAGE, zero["voltage_offset"]) if fact else None
    return None if voltage is None or not part.any() else float(np.mean(voltage[part]))


def _speed(counts: NDArray[Any] | None, driven: NDArray[np.bool_], period_s: float) -> float | None:
    """Counts a second over the last quarter of the driven samples; None: too few of them."""
    if counts is None or driven.sum() < FEWEST:
        return None
    last = counts[driven].astype(np.int64)[-(int(driven.sum()) // 4) :]
    return float((last[-1] - last[0]) / (period_s * (len(last) - 1)))


def _values(board: Board, columns: Any, name: str, offset: float) -> NDArray[np.float64] | None:
    if name not in columns:
        return None
    values = board.descriptors[name]["scale"] * (columns[name].astype(np.float64) - offset)
    return np.asarray(values, dtype=np.float64)
