"""Everything a product may limit: how each quantity follows from an estimate.

Parameters and figures are at 25 °C, as the estimate has them (``estimate.temperature``) but by the
product's own coefficients; the uncertainty of the temperature is in theirs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from motorid.capture.model import CURRENT, POSITION
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.results.estimate import MEANING, PARAMETERS, UNITS, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty.reference_temperature import (
    COLD,
    Warmth,
    ambient_of,
    at_25,
    warmth_of,
)
from motorid.motor.brushes import figure
from motorid.motor.parameters import FIGURES, Motor
from motorid.quality import levels, ripple
from motorid.quality.temperature import Temperature
from motorid.quality.verdict import Reading

COGGING_SHAPE = 0.01  # of it: the fit has it in straight lines, 1 % short at 10 times the friction
SAME_LEVEL = 0.1  # of a level: so near is its reading to what the fit took it for
NOT_STEADY = (
    "the run holds no steady stretch of two turns with current and position: drive longer at a "
    "constant level"
)


@dataclass(frozen=True)
class Quantity:
    """A name of the product file: unit, meaning, and how it is read."""

    unit: str
    meaning: str
    read: Callable[[Context], Reading]


class Inspected(Protocol):
    """What is read of a product here; ``motorid.quality.product.Product`` has it all."""

    @property
    def voltage_v(self) -> float:
        """Nominal."""

    @property
    def segments(self) -> int:
        """Bars of the commutator; 0: unknown."""

    @property
    def commutations_per_turn(self) -> int:
        """0: unknown."""

    @property
    def temperature(self) -> Temperature:
        """How R and K follow it."""


class Context:
    """One estimate as a product looks at it; what several quantities need is computed once."""

    def __init__(self, estimate: Estimate, product: Inspected) -> None:
        self.estimate, self.product = estimate, product

    @cached_property
    def windows(self) -> tuple[ripple.Window, ...]:
        """The steady stretches."""
        return ripple.windows(self.estimate)

    @cached_property
    def warmth(self) -> Warmth | None:
        """K above 25 °C; None where the ambient was not given, or the self-heating is unknown."""
        rise = self.product.temperature.rise(self.estimate.rise)
        if rise is None or not ambient_of(self.estimate.inputs)[2]:
            return None
        return warmth_of(self.estimate.inputs, rise)

    @cached_property
    def as_run(self) -> Motor | None:
        """The motor as run; None where a parameter is not known."""
        values = {n: self.estimate.parameters[n].value for n in PARAMETERS}
        if any(v is None for v in values.values()):
            return None
        return Motor.of({n: v for n, v in values.items() if v is not None})

    @cached_property
    def motor(self) -> Motor | None:
        """The motor at 25 °C; None where a parameter is not known."""
        if self.as_run is None or self.warmth is None:
            return None
        t = self.product.temperature
        return replace(
            self.as_run,
            R=self.as_run.R / (1.0 + t.copper_per_k * self.warmth.winding),
            K=self.as_run.K / (1.0 + t.magnet_per_k * self.warmth.magnets),
        )

    def doubt(self, *names: str) -> str:
        """Why a figure that rests on these parameters cannot be judged; "": nothing is known."""
        found = (self.estimate.parameters[name] for name in names)
        return next((f"{p.name} is {p.note}" for p in found if p.status is Status.DOUBTFUL), "")

    @property
    def resistance(self) -> float | None:
        """As run, ohm."""
        return self.estimate.parameters["R"].value


def of_parameter(p: Parameter) -> Reading:
    """What the estimate says; a friction held at 0 counts as measured, with its uncertainty."""
    if p.value is None or p.status.unknown:
        return Reading(p.unit, problem=p.note or "these data do not tell it")
    if p.status is Status.DOUBTFUL:
        return Reading(p.unit, problem=p.note)
    if p.status is Status.FIXED:
        return Reading(p.unit, problem="it was given, not measured: fit without fixing it")
    return Reading(p.unit, p.value, p.total)


def _plain(name: str) -> Callable[[Context], Reading]:
    return lambda c: of_parameter(c.estimate.parameters[name])


def _at_25(name: str) -> Callable[[Context], Reading]:
    def read(c: Context) -> Reading:
        hot = of_parameter(c.estimate.parameters[name])
        if hot.value is None or hot.uncertainty is None:
            return hot
        if c.warmth is None:
            return Reading(hot.unit, problem="the ambient is not known: give it in the rig file")
        cold = at_25(c.estimate.parameters, c.warmth, c.product.temperature)[0][COLD[name]]
        return Reading(cold.unit, cold.value, cold.total)

    return read


def _figure(name: str) -> Callable[[Context], Reading]:
    """At the product's voltage; the relative uncertainty is that of the estimate's own figure."""

    def read(c: Context) -> Reading:
        own = c.estimate.derived.get(name)
        if own is None or own.value is None or own.total is None or c.motor is None:
            return Reading(FIGURES[name].unit, problem="the parameters it follows from are unknown")
        if own.status is Status.DOUBTFUL:
            return Reading(FIGURES[name].unit, problem=own.note.rpartition("; ")[2])
        volts, brushes = c.product.voltage_v, c.estimate.brushes
        value = figure(name, c.motor, volts, brushes)
        t, w = c.product.temperature, c.warmth
        doubt = math.hypot(w.ambient_uncertainty, w.rise_uncertainty) if w else 0.0
        warmer = Motor.of(
            dict(zip(PARAMETERS, c.motor.values, strict=True))
            | {
                "R": c.motor.R * (1 + t.copper_per_k * doubt),
                "K": c.motor.K * (1 + t.magnet_per_k * doubt),
            }
        )
        moved = figure(name, warmer, volts, brushes) - value
        u = math.hypot(value * own.total / own.value, moved)
        return Reading(FIGURES[name].unit, value, u)

    return read


def _direction_current(c: Context) -> Reading:
    """Departures from a friction common to both directions, in the steady stretches."""
    ahead, back = _directions(c)
    if not ahead or not back:
        return Reading("1", problem=f"{NOT_STEADY}, in both directions")
    means, variance = [], 0.0
    for side in (ahead, back):
        sign = math.copysign(1.0, side[0].speed)
        left = np.concatenate([sign * w.current for w in side])
        means.append(float(left.mean()))
        variance += float(left.var()) / len(left)
    level = float(np.mean([abs(w.mean_current) for w in (*ahead, *back)]))
    offset = max(
        (p.total or 0.0 for n, p in c.estimate.nuisance.items() if n.startswith("current offset")),
        default=0.0,
    )
    u = math.hypot(math.sqrt(variance), 2.0 * offset) / level
    return Reading("1", abs(means[0] - means[1]) / level, u)


def _direction_speed(c: Context) -> Reading:
    """Relative difference of speed per volt, by the slope of the position's residual, and by what
    the fit took a level for beside its readings: a level that is free follows the speed.
    """
    ahead, back = _directions(c)
    if not ahead or not back:
        return Reading("1", problem=f"{NOT_STEADY}, in both directions")
    ratios, variance = [], 0.0
    for side in (ahead, back):
        excess, weight = 0.0, 0.0
        for w in side:
            turned = w.angle - w.angle.mean()
            slope = float(turned @ w.position / (turned @ turned))
            variance += float(w.position.var() / (turned @ turned)) / len(side) ** 2
            excess, weight = excess + slope + _above_reading(w, c), weight + 1.0
        ratios.append(excess / weight)
    offset = max(
        (p.total or 0.0 for n, p in c.estimate.nuisance.items() if n.startswith("voltage offset")),
        default=0.0,
    )
    level = float(np.mean([abs(w.level) for w in (*ahead, *back)]))
    u = math.hypot(math.sqrt(variance), 2.0 * offset / level)
    return Reading("1", abs(ratios[0] - ratios[1]), u)


def _above_reading(w: ripple.Window, c: Context) -> float:
    """By what share the fit took a level for more than was read of it; 0: nothing was read."""
    read = [m.voltage_v for m in c.estimate.levels if m.voltage_v]
    near = min(read, key=lambda v: abs(v - w.level), default=0.0)
    share = w.level / near - 1.0 if near else 0.0
    return share if abs(share) < SAME_LEVEL else 0.0


def _directions(c: Context) -> tuple[list[ripple.Window], list[ripple.Window]]:
    return [w for w in c.windows if w.speed > 0], [w for w in c.windows if w.speed < 0]


def _ripple(turn: bool) -> Callable[[Context], Reading]:
    def read(c: Context) -> Reading:
        commutation = c.product.commutations_per_turn
        if problem := c.doubt("R"):
            return Reading("1", problem=problem)
        if not c.windows or c.resistance is None:
            return Reading("1", problem=NOT_STEADY)
        orders = list(dict.fromkeys((*ripple.TURN_ORDERS, commutation, 2 * commutation)))
        among = ripple.TURN_ORDERS if turn else (commutation,)
        value, u, order = ripple.relative_ripple(c.windows, c.resistance, orders, among)
        return Reading("1", value, u, note=f"{order} times a turn" if turn else "")

    return read


def _segment(c: Context) -> Reading:
    if problem := c.doubt("R"):
        return Reading("1", problem=problem)
    if not c.windows or c.resistance is None:
        return Reading("1", problem=NOT_STEADY)
    segments = c.product.segments
    value, u, worst = ripple.segment_ripple(c.windows, c.resistance, segments)
    return Reading("1", value, u, note=f"segment {worst + 1} of {segments} from the start")


def _torque(unbalance: bool) -> Callable[[Context], Reading]:
    def read(c: Context) -> Reading:
        if problem := c.doubt("K", "J"):
            return Reading("N·m", problem=problem)
        constant, inertia = (c.estimate.parameters[n].value for n in ("K", "J"))
        if not c.windows or constant is None or inertia is None:
            return Reading("N·m", problem=NOT_STEADY)
        found = ripple.turn_torque(c.windows, constant, inertia)
        if unbalance:
            return Reading("N·m", found.unbalance, found.unbalance_sd)
        return Reading("N·m", found.peak_to_peak, found.peak_to_peak_sd)

    return read


def _cogging(c: Context) -> Reading:
    """0 where none stands out of the noise: what the run cannot show is within its residuals."""
    found = [one for one in c.estimate.repeating if one.quantity == COGGING.name]
    if not found:
        return Reading(COGGING.unit, 0.0, 0.0, note="none stands out of the noise")
    if problem := c.doubt("J"):
        return Reading(COGGING.unit, problem=problem)
    value, noise = sum(one.amplitude for one in found), (one.uncertainty for one in found)
    inertia = c.estimate.parameters["J"]  # every torque has the same scale
    scale = (inertia.total or 0.0) / inertia.value if inertia.value else 0.0
    times = " and ".join(str(one.per_turn) for one in found)
    return Reading(
        COGGING.unit,
        value,
        math.hypot(*noise, scale * value, COGGING_SHAPE * value),
        note=f"{times} times a turn",
    )


def _brush(c: Context) -> Reading:
    found = [ripple.brush_noise(k) for k in c.estimate.curves if k.channel == CURRENT]
    if not found or not all(math.isfinite(value) for value, _ in found):
        return Reading("1", problem="too little of the run carries current: accelerate longer")
    value, u = max(found)
    return Reading("1", value, u)


def _shape(channel: str, unit: str) -> Callable[[Context], Reading]:
    def read(c: Context) -> Reading:
        left = [k.measured - k.fitted for k in c.estimate.curves if k.channel == channel]
        if not left:
            return Reading(unit, problem=f"the captures hold no {channel}")
        rms = [float(np.sqrt((r**2).mean())) for r in left]
        value = max(rms)
        return Reading(unit, value, value / math.sqrt(2.0 * len(left[rms.index(value)])))

    return read


def _curve(c: Context) -> Reading:
    e = c.estimate
    freedom = max(e.degrees_of_freedom, 1)
    return Reading("1", math.sqrt(e.chi_square / freedom), math.sqrt(0.5 / freedom))


def quantity(name: str) -> Quantity | None:
    """What a product file names, a level of the voltage in it or not; None: there is no such."""
    at = levels.stated(name)
    if at is None:
        return QUANTITIES.get(name)

    def read(c: Context) -> Reading:
        return levels.read(at, c.estimate.levels, c.product.voltage_v)

    return Quantity(levels.UNIT[at.kind], at.meaning, read)


QUANTITIES: Mapping[str, Quantity] = {
    "R_25": Quantity("ohm", "resistance at 25 °C", _at_25("R")),
    "K_25": Quantity("N·m/A", "torque constant at 25 °C", _at_25("K")),
    **{n: Quantity(UNITS[n], MEANING[n], _plain(n)) for n in PARAMETERS},
    **{n: Quantity(f.unit, f"{f.meaning} at 25 °C", _figure(n)) for n, f in FIGURES.items()},
    "direction_current": Quantity("1", "current, forward against reverse", _direction_current),
    "direction_speed": Quantity("1", "speed, forward against reverse", _direction_speed),
    "ripple_commutation": Quantity("1", "commutation ripple", _ripple(False)),
    "ripple_turn": Quantity("1", "ripple over a turn", _ripple(True)),
    "ripple_segment": Quantity("1", "worst segment against the others", _segment),
    "friction_turn": Quantity("N·m", "torque variation over a turn", _torque(False)),
    "unbalance": Quantity("N·m", "unbalance torque", _torque(True)),
    "cogging": Quantity(COGGING.unit, "cogging torque", _cogging),
    "brush_noise": Quantity("1", "scatter of the current", _brush),
    "shape_current": Quantity("A", "current against the model, rms", _shape(CURRENT, "A")),
    "shape_position": Quantity("rad", "position against the model, rms", _shape(POSITION, "rad")),
    "curve_shape": Quantity("1", "residuals over declared noise", _curve),
}
