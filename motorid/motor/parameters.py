"""The six parameters of the motor and the figures that follow from them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import astuple, dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Motor:
    """``v = R i + L di/dt + K w`` and ``J dw/dt = K i - B w - T0 sign(w)``, in SI units."""

    R: float  # ohm
    L: float  # H; 0 leaves the inductance out
    K: float  # N·m/A = V·s/rad
    B: float  # N·m·s/rad
    J: float  # kg·m²
    T0: float  # N·m

    @classmethod
    def of(cls, values: Mapping[str, float]) -> Motor:
        """From a mapping with (at least) the keys R, L, K, B, J, T0."""
        return cls(*(float(values[name]) for name in cls.__slots__))

    @property
    def values(self) -> tuple[float, ...]:
        """(R, L, K, B, J, T0)."""
        return astuple(self)


class Figure(NamedTuple):
    """A derived quantity: its unit, its meaning and how it follows from motor and voltage."""

    unit: str
    meaning: str
    of: Callable[[Motor, float], float]


def no_load_speed(motor: Motor, voltage_v: float) -> float:
    """rad/s, where the motor's torque equals its own friction. 0 when it does not start."""
    m = motor
    return max(0.0, (m.K * voltage_v - m.R * m.T0) / (m.K**2 + m.R * m.B))


def stall_current(motor: Motor, voltage_v: float) -> float:
    """A, with the shaft held."""
    return voltage_v / motor.R


def stall_torque(motor: Motor, voltage_v: float) -> float:
    """N·m at the shaft that just holds it: the Coulomb torque is inside the motor."""
    return max(0.0, motor.K * stall_current(motor, voltage_v) - motor.T0)


def peak_efficiency(motor: Motor, voltage_v: float) -> float:
    """Largest ratio of shaft power to electrical power over all loads, 0 to 1.

    With a load the speed is w, the current i = (V - K w)/R and the shaft's torque
    K i - B w - T0; the ratio w (K i - B w - T0) / (V i) is largest where its derivative
    in w vanishes, at w = (1 - s) V/K with s² = (B V + K T0) R / ((K² + R B) V): it is then
    (1 + R B/K²) (1 - s)².
    """
    m, v = motor, voltage_v
    if no_load_speed(m, v) <= 0:
        return 0.0
    s = math.sqrt((m.B * v + m.K * m.T0) * m.R / ((m.K**2 + m.R * m.B) * v))
    return (1.0 + m.R * m.B / m.K**2) * (1.0 - s) ** 2


def mechanical_time_constant(motor: Motor, voltage_v: float = 0.0) -> float:
    """s, of the speed after a step of voltage when the inductance is negligible."""
    return motor.J * motor.R / (motor.K**2 + motor.R * motor.B)


FIGURES: dict[str, Figure] = {
    "no_load_speed": Figure("rad/s", "speed without load at the voltage given", no_load_speed),
    "stall_current": Figure("A", "current with the shaft held", stall_current),
    "stall_torque": Figure("N·m", "shaft torque that holds it", stall_torque),
    "electrical_time_constant": Figure("s", "L/R", lambda m, v: m.L / m.R),
    "mechanical_time_constant": Figure("s", "J R/(K² + R B)", mechanical_time_constant),
    "Kv": Figure("rpm/V", "speed constant, 1/K", lambda m, v: 30.0 / math.pi / m.K),
    "peak_efficiency": Figure("1", "largest shaft power per electrical power", peak_efficiency),
}
