"""A motor integrated in small steps, sharing nothing with the fit: what other people log.

L di/dt = v − R i − K ω,    J dω/dt = K i − B ω − T0 sign ω
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Drive = Callable[[float, float], float | None]  # (time s, speed rad/s) -> V; None: open

STEP_S = 2e-5  # a fiftieth of L/R


@dataclass(frozen=True)
class Motor:
    """SI units. L/R is 1 ms and the mechanical time constant 40 ms."""

    R: float = 2.0
    L: float = 2e-3
    K: float = 0.05
    B: float = 2e-5
    J: float = 5e-5
    T0: float = 4e-3


@dataclass(frozen=True)
class Trace:
    """What was true, at every step: s, V, A, rad/s, rad; shapes (n,)."""

    time_s: Floats
    volts: Floats
    current: Floats
    speed: Floats
    angle: Floats

    def at(self, what: Floats, stamps_s: Floats) -> Floats:
        """One of the above at other times."""
        return np.interp(stamps_s, self.time_s, what)


def turn(motor: Motor, drive: Drive, length_s: float, speed: float = 0.0) -> Trace:
    """The motor from ``speed`` (rad/s) on, the current by the trapezoidal rule; dry friction holds
    at standstill.
    """
    n, h = round(length_s / STEP_S), STEP_S
    m = motor
    out = np.zeros((n, 4))
    current = angle = 0.0
    slow, drag = h * m.R / m.L / 2, 1 + h * m.B / m.J
    rub = h * m.T0 / m.J / drag
    for k in range(n):
        volts = drive(k * h, speed)
        if volts is None:
            volts, current = m.K * speed, 0.0
        out[k] = volts, current, speed, angle
        if volts != m.K * speed or current:
            current = ((1 - slow) * current + h / m.L * (volts - m.K * speed)) / (1 + slow)
        moved = (speed + h / m.J * m.K * current) / drag
        new = (moved > 0) * max(moved - rub, 0.0) + (moved < 0) * min(moved + rub, 0.0)
        angle += h * (speed + new) / 2
        speed = new
    return Trace(np.arange(n) * h, *out.T)
