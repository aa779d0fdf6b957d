"""The first drive: a short weak pulse that shows signs, encoder and current."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.acquire.board import Board, Fields
from motorid.acquire.drive import Stop, drive, load, tripped
from motorid.acquire.plan import wire_program
from motorid.acquire.safety import pulse_resistance
from motorid.acquire.timeline import Timeline
from motorid.capture.model import CURRENT, VOLTAGE
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Rig, settling_s
from motorid.wire.enums import ChannelKind

DUTIES = (0.1, 0.2, 0.35)  # of the supply, rising until the motor moves
MOVED = 4  # encoder counts, more than an edge's flicker
CLEAR = 5.0  # standard deviations that tell a reading from noise
BEFORE_S, AFTER_S = 0.01, 0.02
WHOLE = 1e-3  # of an aperture, by which it may miss a whole number of PWM periods


@dataclass(frozen=True)
class Pulse:
    """What a pulse showed. Currents and volts are means while driving, less those before."""

    duty: float
    volts: float  # applied: duty times supply
    counts: int  # encoder, until the end of the run
    current_a: float | None
    current_noise_a: float
    peak_a: float
    saturated: bool
    voltage_v: float | None

    @property
    def draws(self) -> bool:
        """Whether current clearly flowed."""
        return self.current_a is not None and abs(self.current_a) > CLEAR * self.current_noise_a


def check_signs(
    board: Board, rig: Rig, config: Fields, zero: Fields, supply_v: float, stop: Stop
) -> Fields:
    """Pulses until the motor moves, and judges what it saw; the figures for the capture.

    Raises RigError with what to do: the motor does not move, encoder or current reversed, current
    sensor dead or saturated, sense wires missing or swapped.
    """
    pulse = braked = None
    for duty in _duties(rig, supply_v):
        pulse = weak_pulse(board, rig, config, zero, stop, duty, supply_v)
        if pulse is None:
            return {}
        judge_sensors(rig, pulse)
        if abs(pulse.counts) >= MOVED:
            _judge_encoder(rig, pulse)
            found = asdict(pulse) | {"resistance_bound_ohm": _bound(pulse)}
            if reads_means(board):
                _judge_current(pulse)
                board.wait_for_rest()
                return found
            board.wait_for_rest()
            braked = weak_pulse(board, rig, config, zero, stop, duty, supply_v, braking=True)
            if braked is None:
                return {}
            if _brakes(braked):
                board.wait_for_rest()
                return found
        board.wait_for_rest()
    raise RigError(_why_still(pulse) if braked is None else _why_dead(braked))


def check_supply(board: Board, rig: Rig) -> float:
    """The supply's voltage. Raises RigError when it is missing or outside the limits."""
    measured = board.supply_v()
    limits = rig.limits
    if measured is None:
        return rig.supply_voltage_v or limits.supply_max_v
    if measured < limits.supply_min_v:
        raise RigError(
            f"the supply reads {measured:.2f} V, below limits.supply_min_v = "
            f"{limits.supply_min_v:g}: is it connected and switched on?"
        )
    if measured > limits.supply_max_v:
        raise RigError(
            f"the supply reads {measured:.2f} V, above limits.supply_max_v = "
            f"{limits.supply_max_v:g}: turn it down"
        )
    return measured


def check_zero(zero: Fields, descriptors: dict[str, Fields]) -> None:
    """Raises RigError when the current sensor stands at an end of its range with no current."""
    fact = descriptors.get(CURRENT)
    if fact and not fact["raw_min"] < zero["current_offset"] < fact["raw_max"]:
        raise RigError(
            f"the current sensor reads {zero['current_offset']:.0f} counts with the bridge open, "
            "an end of its range: check its supply and its wires"
        )


def _duties(rig: Rig, supply_v: float) -> Iterator[float]:
    """Duties weak enough for the rig: below 80 % of the current limit if the motor is locked."""
    resistance = rig.nameplate.resistance_ohm
    for duty in DUTIES:
        if resistance and duty * supply_v / resistance > 0.8 * rig.limits.current_a:
            yield 0.8 * rig.limits.current_a * resistance / supply_v
            return
        yield duty


def weak_pulse(
    board: Board,
    rig: Rig,
    config: Fields,
    zero: Fields,
    stop: Stop,
    duty: float,
    supply_v: float,
    braking: bool = False,
) -> Pulse | None:
    """One pulse, and what it showed while driving, or ``braking`` after it; None: stopped."""
    drive_s = min(max(3 * settling_s(rig.nameplate) / 8, 0.06), 0.3)
    steps = (
        Step(StepKind.COAST, BEFORE_S),
        Step(StepKind.DRIVE_DUTY, drive_s, duty, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.BRAKE if braking else StepKind.COAST, AFTER_S),
    )
    period = config["sample_period_ticks"]
    wire = wire_program(Program(steps), board.identity, period)
    load(board, wire)
    timeline = Timeline(period)
    before = board.position()
    reason = drive(board, wire, config, stop, timeline.add)
    if stop.requested:
        return None
    if reason.startswith("fault"):
        raise RigError(f"in the first weak pulse ({duty:.0%} duty) {tripped(reason)}")
    counts = board.position() - before
    if not timeline.blocks:
        raise RigError("the board sent no samples of the first pulse: its firmware is at fault")
    before_it, shown = (2, wire.steps[2]) if braking else (1, wire.steps[1])
    first = timeline.blocks.firsts[0] + sum(step["ticks"] for step in wire.steps[:before_it])
    return _measure(board, timeline, zero, duty, supply_v, counts, first, shown["ticks"])


def _measure(
    board: Board,
    timeline: Timeline,
    zero: Fields,
    duty: float,
    supply_v: float,
    counts: int,
    first: int,
    ticks: int,
) -> Pulse:
    arrays = timeline.arrays()
    driven = (arrays.ticks > first) & (arrays.ticks <= first + ticks)
    current = _values(board, arrays.columns, CURRENT, zero["current_offset"])
    voltage = _values(board, arrays.columns, VOLTAGE, zero["voltage_offset"])
    if not driven.any():
        raise RigError("every sample of the first pulse was lost: check the cable")
    noise, peak, saturated = 0.0, 0.0, False
    if current is not None:
        fact = board.descriptors[CURRENT]
        raw = arrays.columns[CURRENT][driven]
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


def _values(board: Board, columns: Any, name: str, offset: float) -> NDArray[np.float64] | None:
    if name not in columns:
        return None
    values = board.descriptors[name]["scale"] * (columns[name].astype(np.float64) - offset)
    return np.asarray(values, dtype=np.float64)


def judge_sensors(rig: Rig, pulse: Pulse) -> None:
    """What is wrong whether or not the motor moved."""
    if pulse.saturated:
        raise RigError(
            f"the current sensor is at an end of its range at {pulse.duty:.0%} duty: the motor is "
            "shorted, or the sensor is dead or too small"
        )
    volts = pulse.voltage_v
    if volts is None or rig.voltage_sense == "supply":
        return
    if volts < -0.3 * pulse.volts:
        raise RigError(
            f"the terminal voltage reads {volts:.2f} V while +{pulse.volts:.2f} V drives: swap "
            "the two sense wires"
        )
    if volts < 0.3 * pulse.volts:
        raise RigError(
            f"the terminal voltage reads {volts:.2f} V while {pulse.volts:.2f} V should drive: "
            "check the bridge's enable and supply, and the sense wires"
        )


def reads_means(board: Board) -> bool:
    """Whether the current's reading is a mean over whole PWM periods.

    Over part of a period it may show little, or be negative, while the mean is positive: ripple
    turns the current of a light load round.
    """
    fact = board.descriptors.get(CURRENT)
    if fact is None:
        return True
    periods = fact["aperture_ns"] * 1e-9 * board.identity["pwm_hz"]
    whole = abs(periods - round(periods)) < WHOLE * periods
    return bool(whole and fact["kind"] == ChannelKind.MEAN)


def _brakes(pulse: Pulse) -> bool:
    """Whether current flows while the motor brakes. It knows no ripple, whatever part is read.

    Raises RigError where it flows the wrong way.
    """
    if pulse.draws and (pulse.current_a or 0.0) > 0.0:
        raise RigError(
            f"the current reads {pulse.current_a:.3g} A while the motor is braked from a positive "
            "speed: the sensor is reversed; swap its two wires"
        )
    return pulse.draws or pulse.current_a is None


def _why_dead(braked: Pulse) -> str:
    return (
        f"the motor turns at {braked.duty:.0%} duty, but the current sensor reads "
        f"{braked.current_a:.3g} A while it is braked: it is dead or not in the motor's line"
    )


def _judge_encoder(rig: Rig, pulse: Pulse) -> None:
    """What is wrong in how the motor moved."""
    if pulse.counts < 0:
        other = str(not rig.encoder_reversed).lower()
        raise RigError(
            f"the encoder counts backwards ({pulse.counts} counts) under positive voltage: set "
            f"wiring.encoder_reversed = {other}, or swap the motor's leads"
        )


def _judge_current(pulse: Pulse) -> None:
    """What is wrong in the mean current while it moved."""
    if pulse.current_a is None:
        return
    if not pulse.draws:
        raise RigError(
            f"the motor turns at {pulse.duty:.0%} duty, but the current sensor reads "
            f"{pulse.current_a:.3g} A: it is dead or not in the motor's line"
        )
    if pulse.current_a < 0:
        raise RigError(
            f"the current reads {pulse.current_a:.3g} A under positive voltage: the sensor is "
            "reversed; swap its two wires"
        )


def _why_still(pulse: Pulse | None) -> str:
    if pulse is None:
        return "no pulse is weak enough for limits.current_a: raise it"
    if pulse.draws:
        return (
            f"the encoder stands still at {pulse.duty:.0%} duty though the motor draws "
            f"{pulse.current_a:.3g} A: free the shaft, or check the encoder's wires"
        )
    return (
        f"the motor does not move at {pulse.duty:.0%} duty ({pulse.volts:.2f} V) and draws "
        "nothing: check its leads, the bridge's enable and the supply"
    )


def _bound(pulse: Pulse) -> float | None:
    drawn = pulse.draws and (pulse.current_a or 0.0) > 0.0
    return pulse_resistance(pulse.volts, pulse.peak_a) if drawn and pulse.peak_a else None
