"""The first drive: weak pulses that show signs, encoder and current, and what is wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict

from motorid.acquire.board import Board, Fields
from motorid.acquire.encoder_scale import judge_scale
from motorid.acquire.interrupt import Asked
from motorid.acquire.pulse import MOVED, Pulse, weak_pulse
from motorid.acquire.safety import pulse_resistance
from motorid.acquire.signs import Sign, SignError, seen
from motorid.capture.model import CURRENT
from motorid.errors import RigError
from motorid.rig import Rig
from motorid.wire.enums import ChannelKind

DUTIES = (0.1, 0.2, 0.35)  # of the supply, rising until the motor moves
SWING = 1 / 12  # of a turn: less, and backwards, is a rotor that falls back into its cogging
TURNED, STOOD = 0.3, 0.1  # of the applied voltage, that the open terminals show or do not
FAR = 3.0  # times the nameplate's resistance, or a share of it: another circuit
WHOLE = 1e-3  # of an aperture, by which it may miss a whole number of PWM periods


def check_signs(
    board: Board, rig: Rig, config: Fields, zero: Fields, supply_v: float, stop: Asked
) -> Fields:
    """Pulses until the motor moves, and judges what it saw; the figures for the capture.

    Raises RigError with what to do: the motor does not move, encoder or current reversed, current
    sensor dead or saturated, sense wires missing or swapped.
    """
    pulse = braked = None
    for duty in weak_duties(rig, supply_v):
        pulse = weak_pulse(board, rig, config, zero, stop, duty, supply_v)
        if pulse is None:
            return {}
        judge_sensors(rig, pulse)
        if abs(pulse.counts) >= MOVED and not _swings(rig, pulse):
            _judge_encoder(rig, pulse)
            judge_scale(rig, pulse)
            found = asdict(pulse) | {"resistance_bound_ohm": _bound(pulse)}
            if reads_means(board):
                _judge_current(pulse)
                board.wait_for_rest()
                return found
            board.wait_for_rest()
            braked = weak_pulse(board, rig, config, zero, stop, duty, supply_v, braking=True)
            if braked is None:
                return {}
            if abs(braked.counts) >= MOVED and _brakes(braked):
                board.wait_for_rest()
                return found
        board.wait_for_rest()
    if braked is None or abs(braked.counts) < MOVED:
        raise _why_still(rig, braked or pulse)
    raise RigError(_why_dead(braked))


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


def weak_duties(rig: Rig, supply_v: float) -> Iterator[float]:
    """Duties weak enough for the rig: below 80 % of the current limit if the motor is locked."""
    resistance = rig.nameplate.resistance_ohm
    for duty in DUTIES:
        if resistance and duty * supply_v / resistance > 0.8 * rig.limits.current_a:
            yield 0.8 * rig.limits.current_a * resistance / supply_v
            return
        yield duty


def judge_sensors(rig: Rig, pulse: Pulse) -> None:
    """What is wrong whether or not the motor moved."""
    if pulse.saturated:
        raise seen(
            Sign.SHORTED,
            f"the current sensor is at an end of its range at {pulse.duty:.0%} duty: the motor is "
            "shorted, or the sensor is dead or too small",
        )
    volts = pulse.voltage_v
    if volts is None or rig.voltage_sense == "supply":
        return
    if volts < -0.3 * pulse.volts:
        raise RigError(
            f"the terminal voltage reads {volts:.2f} V while +{pulse.volts:.2f} V drives: swap "
            "the two sense wires"
        )
    if volts < 0.3 * (pulse.volts - rig.wiring.bridge_drop_v):
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
        raise seen(
            Sign.BACKWARDS,
            f"the encoder counts backwards ({pulse.counts} counts) under positive voltage: set "
            f"wiring.encoder_reversed = {other}, or swap the motor's leads",
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


def _swings(rig: Rig, pulse: Pulse) -> bool:
    """Whether the rotor only fell back: a turning one shows more, whichever way it is counted."""
    return pulse.counts < 0 and -pulse.counts < SWING * rig.wiring.counts_per_turn


def _why_still(rig: Rig, pulse: Pulse | None) -> RigError:
    if pulse is None:
        return RigError(
            "no pulse is weak enough for limits.current_a: state the nameplate's resistance, or "
            "lower the supply"
        )
    at = f"at {pulse.duty:.0%} duty ({pulse.volts:.2f} V)"
    if abs(pulse.counts) >= MOVED:
        return seen(
            Sign.SWINGS,
            f"the rotor swings by {pulse.counts} counts {at} and does not turn: it is jammed, or "
            "its cogging is too strong",
        )
    coast = pulse.coast_v
    stood = coast is not None and abs(coast) < STOOD * pulse.volts
    if not pulse.draws or (stood and _circuit(rig, pulse) > FAR):
        drawn = f"{pulse.current_a:.3g} A" if pulse.draws else "nothing"
        return seen(
            Sign.OPEN,
            f"the motor does not move {at} and draws {drawn}: check its leads, the bridge's enable "
            "and the supply",
        )
    said = f"the encoder stands still {at} though the motor draws {pulse.current_a:.3g} A"
    if stood:
        shown = "the open terminals show no voltage of a turning motor"
        return seen(Sign.SEIZED, f"{said}, and {shown}: free the shaft")
    if coast is not None and coast > TURNED * pulse.volts:
        return RigError(
            f"{said}, and the open terminals show {coast:.2f} V of a turning motor: check the "
            "encoder's wires and its supply"
        )
    return SignError(f"{said}: free the shaft, or check the encoder's wires")


def _circuit(rig: Rig, pulse: Pulse) -> float:
    """Voltage over current at standstill, over the nameplate's resistance; 1: nobody stated it."""
    stated = rig.nameplate.resistance_ohm
    if not stated or not pulse.current_a:
        return 1.0
    return abs(pulse.volts / pulse.current_a) / stated


def _bound(pulse: Pulse) -> float | None:
    drawn = pulse.draws and (pulse.current_a or 0.0) > 0.0
    return pulse_resistance(pulse.volts, pulse.peak_a) if drawn and pulse.peak_a else None
