"""Speed and current as measured at a stated level of the voltage: no model, and no derived figure.

``measured_speed`` is at the product's voltage, ``measured_speed@-6`` at the level of -6 V. Both are
positive when the motor turns, and the current flows, the way the voltage asks for.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.results.estimate import Estimate, MeasuredLevel
from motorid.motor.brushes import figure
from motorid.motor.parameters import Motor
from motorid.quality.verdict import Reading

Kind = Literal["speed", "current"]

NAME = re.compile(r"measured_(speed|current)(?:@([+-]?[0-9]+(?:\.[0-9]+)?))?", re.ASCII)
UNIT = {"speed": "rad/s", "current": "A"}
NEAR = 0.05  # of the stated voltage, within which a level counts as that level
OF_CORRECTION = 0.3  # standard uncertainty of a reduction to the stated voltage, relative
SURE = 3.0  # standard uncertainties of a difference
LITTLE = 0.01  # of the extent of the current: a level's is known better
CLEAR = 5.0  # standard uncertainties of nothing
NOISE = 7.0  # standard deviations, beyond which no noise goes
ROBUST = 1.4826 / math.sqrt(2.0)  # standard deviation over the median step between readings
FEWEST = 32  # readings
DEAD = "the current sensor is dead or not in the motor's line"


@dataclass(frozen=True)
class Stated:
    """What a name of a product file asks for; ``volts`` None: at the product's voltage."""

    kind: Kind
    volts: float | None

    @property
    def meaning(self) -> str:
        """For the operator."""
        at = "the product's voltage" if self.volts is None else f"{self.volts:g} V"
        return f"{self.kind} as measured at {at}"


def stated(name: str) -> Stated | None:
    """None: the name is no measured level."""
    found = NAME.fullmatch(name)
    if found is None or (found[2] and float(found[2]) == 0.0):
        return None
    kind: Kind = "speed" if found[1] == "speed" else "current"
    return Stated(kind, float(found[2]) if found[2] else None)


def read(one: Stated, levels: Sequence[MeasuredLevel], voltage_v: float) -> Reading:
    """The level of the stated voltage that is known best, reduced to that voltage."""
    volts, unit = one.volts if one.volts is not None else voltage_v, UNIT[one.kind]
    near = [
        level for level in levels
        if level.voltage_v is not None and abs(level.voltage_v - volts) <= NEAR * abs(volts)
    ]  # fmt: skip
    if not near:
        return Reading(
            unit,
            problem=f"the run holds no steady level of {volts:g} V within {NEAR:.0%} with a "
            "measured voltage: add a step of that voltage to the product's program",
        )
    whole = [level for level in near if not level.problem]
    if not whole:
        return Reading(unit, problem=f"{near[0].problem}: give its step more time")
    readings = [r for level in whole if (r := _at(one.kind, level, volts)) is not None]
    if not readings:
        return Reading(
            unit,
            problem=f"the {one.kind} or the voltage was not measured, or nobody stated its gain "
            "and offset with their uncertainty: calibrate the rig",
        )
    return min(readings, key=lambda r: r.uncertainty or 0.0)


def _at(kind: Kind, level: MeasuredLevel, volts: float) -> Reading | None:
    speed, v, v_u = level.speed_rad_s, level.voltage_v, level.voltage_u
    value, u = (speed, level.speed_u) if kind == "speed" else (level.current_a, level.current_u)
    if value is None or u is None or v is None or v_u is None or speed is None:
        return None
    step = value * (volts - v) / v  # a speed follows its voltage; a friction's current hardly does
    moved = step if kind == "speed" else 0.0
    by_volts = value * v_u / v if kind == "speed" else 0.0
    total = math.hypot(u, by_volts, OF_CORRECTION * step)
    return Reading(UNIT[kind], math.copysign(1.0, volts) * (value + moved), total)


def disagreement(estimate: Estimate, motor: Motor | None) -> str:
    """Where the speed that the parameters give departs from the measured one; "": nowhere.

    The gain of the voltage moves both alike, so that of the derived speed's uncertainty only the
    statistical part counts. ``motor`` is the one as run.
    """
    own = estimate.derived.get("no_load_speed")
    if motor is None or own is None or not own.value or own.statistical is None:
        return ""
    share = own.statistical / own.value
    worst, said = SURE, ""
    for level in estimate.levels:
        v, speed, u = level.voltage_v, level.speed_rad_s, level.speed_u
        if level.problem or not v or speed is None or u is None:
            continue
        derived = math.copysign(figure("no_load_speed", motor, abs(v), estimate.brushes), v)
        off = abs(speed - derived) / math.hypot(u, share * derived)
        if off > worst:
            worst = off
            said = (
                f"at the level of {v:.3g} V the speed is {speed:.4g} rad/s as measured, and "
                f"{derived:.4g} rad/s by the parameters, {off:.2g} standard uncertainties apart: "
                "the run does not support figures that are derived"
            )
    return said


def dead_sensor(estimate: Estimate) -> str:
    """Where the motor turns under a voltage and no current flows, which no motor does; "": none."""
    for curve in estimate.curves:
        if curve.channel != CURRENT or len(curve.measured) < FEWEST:
            continue
        noise = ROBUST * float(np.median(np.abs(np.diff(curve.measured))))
        extent = float(np.ptp(curve.measured))
        if extent < 2.0 * NOISE * noise:
            return f"the current never leaves its noise of {noise:.2g} A: {DEAD}"
        for row in estimate.steady:
            inside = (curve.time_s >= row.start_s) & (curve.time_s <= row.end_s)
            n = int(inside.sum())
            if row.capture != curve.capture or not row.speed_rad_s or n < FEWEST:
                continue
            mean = float(curve.measured[inside].mean())
            u = CLEAR * math.hypot(noise / math.sqrt(n), _offset(estimate))
            if abs(mean) < u < LITTLE * extent:
                return f"the motor turns at {row.speed_rad_s:.4g} rad/s without a current: {DEAD}"
    return ""


def _offset(estimate: Estimate) -> float:
    """A, how well the zero of the current is known."""
    own = (p.total or 0.0 for n, p in estimate.nuisance.items() if n.startswith("current offset"))
    return max(own, default=0.0)
