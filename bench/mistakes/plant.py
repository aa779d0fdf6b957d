"""A brushed motor integrated exactly over small steps, sharing nothing with motorid.

    L di/dt = v - R i - K w,    J dw/dt = K i - B w - T0 sign(w)

Between two ticks of a fine grid the voltage is constant, so the step is a matrix exponential. Dry
friction holds the rotor at standstill. Where the bridge opens, two diodes return the current to a
supply of the nominal voltage until it is zero; the terminals then show the back-EMF.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Floats = NDArray[np.float64]
Drive = Callable[
    [float, float, float], float | None
]  # (s, A, rad/s) -> V; None: the bridge is open
DIODE_V = 0.7


@dataclass(frozen=True)
class Motor:
    """SI units; ``volts`` is the nominal voltage."""

    R: float
    L: float
    K: float
    B: float
    J: float
    T0: float
    volts: float

    @property
    def tau_s(self) -> float:
        """Mechanical time constant."""
        return self.R * self.J / (self.K**2 + self.R * self.B)

    @property
    def stall_a(self) -> float:
        """Current of the held rotor."""
        return self.volts / self.R

    @property
    def top_rad_s(self) -> float:
        """Speed without a load."""
        return (self.volts - self.R * self.T0 / self.K) / (self.K + self.R * self.B / self.K)

    @property
    def truth(self) -> dict[str, float]:
        """The six parameters by name."""
        return {name: getattr(self, name) for name in ("R", "L", "K", "B", "J", "T0")}


@dataclass(frozen=True)
class Trace:
    """What was true: s, V, A, rad/s, rad and whether the bridge was open, shapes (n,).

    ``volts`` is the terminal voltage over the step that begins at its time.
    """

    time_s: Floats
    volts: Floats
    current: Floats
    speed: Floats
    angle: Floats
    opened: NDArray[np.bool_]

    @property
    def step_s(self) -> float:
        """Of the fine grid."""
        return float(self.time_s[1])


def turn(motor: Motor, drive: Drive, length_s: float, step_s: float) -> Trace:
    """The motor from rest, at every tick of the fine grid."""
    m = motor
    (ii, iw, iv, it), (wi, ww, wv, wt) = _step(m, step_s)
    slow = math.exp(-m.B * step_s / m.J)
    rub = m.T0 * step_s / m.J if m.B == 0 else m.T0 / m.B * (1 - slow)
    n = round(length_s / step_s)
    out = np.empty((n, 4))
    opened = np.zeros(n, dtype=bool)
    i = w = angle = 0.0
    for k in range(n):
        v = drive(k * step_s, i, w)
        if v is None and i:
            opened[k] = True
            v = -math.copysign(m.volts + 2 * DIODE_V, i)
        elif v is None:
            opened[k] = True
            out[k] = m.K * w, 0.0, w, angle
            new = math.copysign(max(abs(w) * slow - rub, 0.0), w)
            angle += step_s * (w + new) / 2
            w = new
            continue
        out[k] = v, i, w, angle
        way = math.copysign(1.0, w) if w else math.copysign(1.0, i)
        held = w == 0 and abs(m.K * i) <= m.T0
        drag = 0.0 if held else -m.T0 * way
        new_i = ii * i + iw * w + iv * v + it * drag
        new_w = 0.0 if held else wi * i + ww * w + wv * v + wt * drag
        if new_w * w < 0 or (w == 0 and new_w * way < 0):
            new_w = 0.0
        if opened[k] and new_i * i < 0:
            new_i = 0.0
        angle += step_s * (w + new_w) / 2
        i, w = new_i, new_w
    return Trace(np.arange(n) * step_s, *out.T, opened)


def _step(m: Motor, step_s: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Rows of the map (i, w, v, torque) -> (i, w) over one step."""
    system = np.zeros((4, 4))
    system[:2] = [[-m.R / m.L, -m.K / m.L, 1 / m.L, 0], [m.K / m.J, -m.B / m.J, 0, 1 / m.J]]
    rows = expm(system * step_s)[:2].tolist()
    return tuple(rows[0]), tuple(rows[1])
