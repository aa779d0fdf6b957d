"""What the bridge does to the motor's voltage and current within a PWM period."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture, Wiring
from motorid.errors import DataError
from motorid.estimate.timeline import Part, Timeline
from motorid.motor.response import Stretch
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

NEARLY = 2.0  # times the current that ripple just turns around, up or down: it may or may not
STRAIGHT = 1e-3  # PWM periods over L/R: below it the current runs straight between its ends
DIODE_DROPS_V = 1.4  # of the two diodes that carry a freewheeling current


def supply_voltage(capture: Capture) -> float | None:
    """V at the bridge: measured, else of the rig, else as the board measured it; None: unknown."""
    supply = capture.get(SUPPLY)
    if supply is not None and np.isfinite(supply.values).any():
        return float(np.nanmedian(supply.values))
    if capture.wiring.supply_voltage_v > 0:
        return capture.wiring.supply_voltage_v
    check = capture.provenance.get("check") or {}
    duty, volts = abs(check.get("duty") or 0.0), abs(check.get("volts") or 0.0)
    return volts / duty if duty and volts else None


def clamp_voltage(capture: Capture, highest_v: float) -> float:
    """V that turns a freewheeling current off when the bridge opens: the supply and two diodes.

    ``highest_v``, the highest voltage seen, stands in for a supply that nothing tells.
    """
    return (supply_voltage(capture) or highest_v) + DIODE_DROPS_V


def bridge_prior(capture: Capture) -> tuple[float, float]:
    """The source's resistance (ohm) as declared, and its standard uncertainty; inf: unknown."""
    wiring = capture.wiring
    ohms = wiring.bridge_resistance_ohm
    if ohms <= 0:
        return 0.0, np.inf
    return ohms, wiring.bridge_resistance_uncertainty_ohm or 0.1 * ohms


def pwm_shape(part: Part, level_v: float, rail: float | None) -> tuple[float, float]:
    """(duty 0 to 1, signed swing in V) of a part whose mean voltage is ``level_v``; 0: no ripple.

    Fast decay has none that could be told beforehand: its current stops within the period. With
    diode decay this is the shape while the current flows.
    """
    if part.decay not in (Decay.SYNCHRONOUS_SLOW, Decay.DIODE):
        return 0.0, 0.0
    if part.kind == StepKind.DRIVE_DUTY and part.level:
        duty = abs(part.level)
    elif part.kind == StepKind.DRIVE_VOLTS and rail:
        duty = min(abs(part.level) / rail, 1.0)
    else:
        return 0.0, 0.0
    return (duty, level_v / duty) if duty else (0.0, 0.0)


def stretch_of(
    wiring: Wiring,
    rail: float | None,
    clamp_v: float,
    part: Part,
    start: int,
    ohms: float,
    volts: Floats,
    in_time: bool = False,
) -> Stretch:
    """From ``start`` under a part's command, whose PWM begins in time or a dead time late."""
    late_s = 0.0 if in_time else wiring.dead_time_s
    duty, swing = pwm_shape(part, float(np.mean(volts)), rail)
    left = duty - late_s * wiring.pwm_hz
    if not 0.0 < left < duty < 1.0:
        return Stretch(start, part.open, ohms, clamp_v, duty, swing)
    swing *= duty / left  # the level is the mean of what is left
    return Stretch(start, part.open, ohms, clamp_v, left, swing, late_s)


def switched_late(
    capture: Capture,
    part: Part,
    current: Floats,
    inductance_h: float,
    resistance_ohm: float = 0.0,
) -> int:
    """Interval up to which dead time delays the on part while ``current`` (count,) flows.

    As a motor speeds up its current falls. Once ripple turns it around within the PWM period, a
    diode begins the on part in time.
    """
    if part.decay != Decay.SYNCHRONOUS_SLOW or not part.level or not capture.wiring.pwm_hz:
        return part.start
    below, _ = ripple(capture, part, inductance_h, resistance_ohm)
    late = np.flatnonzero(np.abs(current[part.slice]) >= below)
    return part.start + int(late[-1]) + 1 if len(late) else part.start


def ripple(
    capture: Capture, part: Part, inductance_h: float, resistance_ohm: float = 0.0
) -> tuple[float, float]:
    """A, how far the current swings below its mean within a PWM period, and how far above.

    While the mean is less than the first, the current passes through zero. With a resistance it
    bends on its way, and spends more of the period near one end.
    """
    rail, pwm = supply_voltage(capture), capture.wiring.pwm_hz
    duty, _ = pwm_shape(part, 1.0, rail)
    if part.decay == Decay.FAST:
        duty = 0.5
    if not rail or not pwm or not inductance_h or not 0.0 < duty < 1.0:
        return 0.0, 0.0
    decay = resistance_ohm / (inductance_h * pwm)  # per period
    if decay < STRAIGHT:
        half = rail * duty * (1 - duty) / (2 * inductance_h * pwm)
        return half, half
    on, off = -math.expm1(-decay * duty), -math.expm1(-decay * (1 - duty))
    swing = rail / resistance_ohm / -math.expm1(-decay)
    below = swing * (duty * off - (1 - duty) * on * (1 - off))
    return below, swing * on * off - below


def discontinuous(capture: Capture, timeline: Timeline, inductance_h: float) -> Part | None:
    """The first part in which the current settles below half its ripple and cannot pass zero."""
    current = capture.get(CURRENT)
    if current is None:
        return None
    amperes = timeline.spread(current.values)
    for part in timeline.parts:
        if part.decay not in (Decay.DIODE, Decay.FAST):
            continue
        settled = amperes[(part.start + part.stop) // 2 : part.stop]
        mean = float(np.nanmean(settled)) if np.isfinite(settled).any() else 0.0
        if abs(mean) < ripple(capture, part, inductance_h)[0]:
            return part
    return None


def refuse_discontinuous(capture: Capture, timeline: Timeline, inductance_h: float) -> None:
    """Raises DataError where duty times supply is not the motor's voltage.

    Where the current stops within the PWM period, the motor's voltage is then its own back-EMF.
    """
    channel = capture.get(VOLTAGE)
    if channel is not None and channel.sense in (None, "terminals", "bridge"):
        return
    part = discontinuous(capture, timeline, inductance_h)
    if part is not None:
        raise DataError(
            f"duty times supply is not the motor's voltage: with {part.decay.name.lower()} "
            f"decay the current is discontinuous at level {part.level:g}; measure the voltage "
            "at the terminals, or drive with synchronous decay"
        )


def dead_time_loss(
    capture: Capture,
    parts: Sequence[Part],
    current: Floats,
    inductance_h: float,
    resistance_ohm: float = 0.0,
) -> Floats:
    """V (count,) that the dead time of a synchronous bridge takes from duty times supply.

    Once a period the on part begins late, and twice a diode carries the current instead of a
    switch. Where ripple has turned the current around by then, a diode begins the on part in time
    and nothing is lost. ``current`` (count,) is the model's.
    """
    lost = np.zeros(len(current))
    for part in parts:
        most = _most_lost(capture, part)
        if most:
            here = current[part.slice]
            below, _ = ripple(capture, part, inductance_h, resistance_ohm)
            lost[part.slice] = np.where(np.abs(here) < below, 0.0, most * np.sign(here))
    return lost


def dead_time_doubt(
    capture: Capture, part: Part, current: Floats, inductance_h: float, resistance_ohm: float
) -> float:
    """Standard uncertainty (V) of what the dead time takes from a part, in its mean.

    Near the current that ripple just turns around, cogging or a brush may turn it or not: what is
    lost then lies between nothing and all.
    """
    below, _ = ripple(capture, part, inductance_h, resistance_ohm)
    size = np.abs(current[part.slice])
    near = (size > below / NEARLY) & (size < below * NEARLY)
    return _most_lost(capture, part) / 2 * float(near.mean())


def _most_lost(capture: Capture, part: Part) -> float:
    """V that the dead time takes while the current never turns; 0 where nothing switches."""
    rail = supply_voltage(capture)
    duty, _ = pwm_shape(part, 1.0, rail)
    if part.decay != Decay.SYNCHRONOUS_SLOW or not 0.0 < duty < 1.0 or not rail:
        return 0.0
    return capture.wiring.dead_time_s * capture.wiring.pwm_hz * (rail + DIODE_DROPS_V)
