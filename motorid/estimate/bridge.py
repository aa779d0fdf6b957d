"""What the bridge does to the motor's voltage and current within a PWM period."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY, VOLTAGE, Capture
from motorid.errors import DataError
from motorid.estimate.timeline import Part, Timeline
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

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


def switched_late(capture: Capture, part: Part, current: Floats, inductance_h: float) -> int:
    """Interval up to which dead time delays the on part while ``current`` (count,) flows.

    As a motor speeds up its current falls. Once ripple turns it around within the PWM period, a
    diode begins the on part in time.
    """
    if part.decay != Decay.SYNCHRONOUS_SLOW or not part.level or not capture.wiring.pwm_hz:
        return part.start
    late = np.flatnonzero(np.abs(current[part.slice]) >= half_ripple(capture, part, inductance_h))
    return part.start + int(late[-1]) + 1 if len(late) else part.start


def half_ripple(capture: Capture, part: Part, inductance_h: float) -> float:
    """A, half the swing of the current within a PWM period: below it, it passes through zero."""
    rail, pwm = supply_voltage(capture), capture.wiring.pwm_hz
    duty, _ = pwm_shape(part, 1.0, rail)
    if part.decay == Decay.FAST:
        duty = 0.5
    if not rail or not pwm or not inductance_h:
        return 0.0
    return rail * duty * (1 - duty) / (2 * inductance_h * pwm)


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
        if abs(mean) < half_ripple(capture, part, inductance_h):
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
    capture: Capture, parts: Sequence[Part], current: Floats, inductance_h: float
) -> Floats:
    """V (count,) that the dead time of a synchronous bridge takes from duty times supply.

    Once a period the on part begins late, and twice a diode carries the current instead of a
    switch. Where ripple has turned the current around by then, a diode begins the on part in time
    and nothing is lost. ``current`` (count,) is the model's.
    """
    lost = np.zeros(len(current))
    share = capture.wiring.dead_time_s * capture.wiring.pwm_hz
    rail = supply_voltage(capture)
    for part in parts:
        switches = part.decay == Decay.SYNCHRONOUS_SLOW and abs(part.level) > 0
        if switches and rail and share:
            here = current[part.slice]
            turns = np.abs(here) < half_ripple(capture, part, inductance_h)
            direction = np.where(turns, 0.0, np.sign(here))
            lost[part.slice] = share * (rail + DIODE_DROPS_V) * direction
    return lost
