"""What the bridge does to the motor's voltage and current within a PWM period."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture, Wiring
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Stretch
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]

STRAIGHT = 1e-3  # PWM periods over L/R: below it the current runs straight between its ends
DIODE_DROPS_V = 1.4  # of the two diodes that carry a freewheeling current
DIODE_DROPS_SD_V = 0.23  # two alike, each anywhere from 0.5 to 0.9 V
SWITCHED = (Decay.SYNCHRONOUS_SLOW, Decay.FAST)  # some switch is always closed, but for dead time


def clamp_voltage(capture: Capture, highest_v: float) -> float:
    """V that turns a freewheeling current off when the bridge opens: the supply and two diodes.

    ``highest_v``, the highest voltage seen, stands in for a supply that nothing tells.
    """
    return (capture.supply_v or highest_v) + DIODE_DROPS_V


def bridge_prior(capture: Capture) -> tuple[float, float]:
    """The source's resistance (ohm) as declared, and its standard uncertainty; inf: unknown."""
    wiring = capture.wiring
    ohms = wiring.bridge_resistance_ohm
    if ohms <= 0:
        return 0.0, np.inf
    return ohms, wiring.bridge_resistance_uncertainty_ohm or 0.1 * ohms


def signed_duty(part: Part, rail: float | None) -> float:
    """Of a driven part, -1 to 1; 0 where nothing tells it."""
    if part.kind == StepKind.DRIVE_DUTY:
        return part.level
    if part.kind == StepKind.DRIVE_VOLTS and rail:
        return min(max(part.level / rail, -1.0), 1.0)
    return 0.0


def driven_share(part: Part, rail: float | None) -> tuple[float, float]:
    """Share of the PWM period in which the bridge drives towards the part's level, and the V by
    which the rest of it differs; 0, 0: no PWM that is known.

    The rest is nothing with slow decay, the supply reversed with fast decay; with diode decay the
    supply and two diodes against the current, while that flows.
    """
    duty, supply = abs(signed_duty(part, rail)), rail or 0.0
    match part.decay:
        case Decay.SYNCHRONOUS_SLOW:
            return duty, supply
        case Decay.DIODE:
            return duty, 2.0 * supply + DIODE_DROPS_V
        case Decay.FAST if duty:
            return (1.0 + duty) / 2.0, 2.0 * supply
    return 0.0, 0.0


def pwm_shape(part: Part, level_v: float, rail: float | None) -> tuple[float, float]:
    """(duty 0 to 1, signed swing in V) of a part whose mean voltage is ``level_v``; 0: no ripple.

    The on part is what a PWM period begins with: forward in fast decay, whatever its level.
    """
    share, volts = driven_share(part, rail)
    if not share:
        return 0.0, 0.0
    if part.decay == Decay.SYNCHRONOUS_SLOW:
        return share, level_v / share
    if part.decay == Decay.FAST:
        return (share if part.level > 0 else 1.0 - share), volts
    return share, math.copysign(volts, part.level)


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
    """From ``start`` under a part's command, whose PWM begins in time or a dead time late.

    Of pulses that are aligned to the middle or the end of their period, so much later.
    """
    duty, swing = pwm_shape(part, float(np.mean(volts)), rail)
    late_s, longer_s = _edges(wiring, part, swing, in_time) if 0.0 < duty < 1.0 else (0.0, 0.0)
    left = duty + longer_s * wiring.pwm_hz
    if not 0.0 < left < 1.0:
        late_s, left = 0.0, duty
    if part.decay == Decay.SYNCHRONOUS_SLOW and left:
        swing *= duty / left  # the level is the mean of what is left
    if wiring.pwm_alignment and 0.0 < left < 1.0:
        late_s += wiring.pwm_alignment * (1.0 - left) / wiring.pwm_hz
    known = Stretch(start, part.open, ohms, clamp_v, left, swing, late_s)
    return replace(known, discontinuous=part.discontinuous, still=part.still)


def _edges(wiring: Wiring, part: Part, swing_v: float, in_time: bool) -> tuple[float, float]:
    """Seconds by which the dead time delays the on part, and by which it lengthens it.

    A current against the coming switch keeps a diode conducting that long, whose drop then counts
    like an earlier edge; one that ripple turns round meets the diode of the coming part.
    """
    if part.decay not in SWITCHED:
        return 0.0, 0.0
    drops = DIODE_DROPS_V if part.decay == Decay.FAST else DIODE_DROPS_V / 2
    early = wiring.dead_time_s * drops / max(abs(swing_v), drops)
    if in_time:
        return -early, 0.0
    whole = wiring.dead_time_s + 2 * early
    if part.decay == Decay.FAST and part.level < 0:  # it is the reversed part that begins late
        return -early, whole
    return wiring.dead_time_s + early, -whole


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
    if part.decay not in SWITCHED or not part.level or not capture.wiring.pwm_hz:
        return part.start
    below, _ = ripple(capture, part, inductance_h, resistance_ohm)
    late = np.flatnonzero(np.abs(current[part.slice]) >= below)
    return part.start + int(late[-1]) + 1 if len(late) else part.start


def ripple(
    capture: Capture, part: Part, inductance_h: float, resistance_ohm: float = 0.0
) -> tuple[float, float]:
    """``swings`` of a part's current; towards its level is above."""
    rail = capture.supply_v
    duty, volts = driven_share(part, rail)
    if not rail:
        return 0.0, 0.0
    return swings(volts, duty, capture.wiring.pwm_hz, inductance_h, resistance_ohm)


def swings(
    volts: float, duty: float, pwm_hz: float, inductance_h: float, resistance_ohm: float
) -> tuple[float, float]:
    """A, how far the current swings below its mean within a PWM period, and how far above.

    ``volts`` is the on level less the off level. While the mean is less than the first, the current
    passes through zero. With a resistance it bends on its way, and spends more of the period near
    one end. 0, 0 where nothing switches.
    """
    if not pwm_hz or not inductance_h or not 0.0 < duty < 1.0:
        return 0.0, 0.0
    decay = resistance_ohm / (inductance_h * pwm_hz)  # per period
    if decay < STRAIGHT:
        half = volts * duty * (1 - duty) / (2 * inductance_h * pwm_hz)
        return half, half
    on, off = -math.expm1(-decay * duty), -math.expm1(-decay * (1 - duty))
    swing = volts / resistance_ohm / -math.expm1(-decay)
    below = swing * (duty * off - (1 - duty) * on * (1 - off))
    return below, swing * on * off - below
