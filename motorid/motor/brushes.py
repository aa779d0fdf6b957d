"""Figures of a motor at a voltage, of which its brushes drop some.

    V = R i + K w + U(i),    U(i) = U s,    s = i / sqrt(i² + b²)

U is the drop over both brushes at large current, b the current at which it bends. Where PWM swings
the current, U(i) is a mean over the swing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from motorid.motor.parameters import FIGURES, Motor

PASSES = 50  # of the halving
STEP = 1e-4  # of a current or a logarithm, for a derivative
AT_A_VOLTAGE = ("no_load_speed", "stall_current", "stall_torque", "peak_efficiency")


@dataclass(frozen=True)
class Brushes:
    """The drop and its bend; the covariance (V²) of the drop and of drop times ln(bend).

    ``swing_a``: by how much PWM swings the current to each side of its mean: the mean of a drop
    that bends is less then.
    """

    drop_v: float
    bend_a: float
    swing_a: float = 0.0
    variances: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of both, and between them

    def drop(self, amperes: float) -> float:
        """V at a mean current of either sign."""
        return self.drop_v * self._share(amperes, self.bend_a)

    def slope(self, amperes: float) -> float:
        """Ohm, by which the drop adds to the resistance for a small change of current."""
        step = STEP * max(self.bend_a, abs(amperes))
        return (self.drop(amperes + step) - self.drop(amperes - step)) / (2.0 * step or 1.0)

    def uncertainty(self, amperes: float) -> float:
        """Standard uncertainty of ``drop`` (V)."""
        share = self._share(amperes, self.bend_a)
        around = [self._share(amperes, self.bend_a * math.exp(side * STEP)) for side in (-1, 1)]
        bending = (around[1] - around[0]) / (2.0 * STEP)
        own, bend, both = self.variances
        variance = share**2 * own + bending**2 * bend + 2.0 * share * bending * both
        return math.sqrt(max(variance, 0.0))

    def _share(self, amperes: float, bend: float) -> float:
        """Mean of s over a current that runs evenly between its ends."""
        if bend <= 0.0:
            return math.copysign(1.0, amperes) if amperes else 0.0
        half = max(self.swing_a, STEP * bend)
        ends = (math.hypot(amperes + half, bend), math.hypot(amperes - half, bend))
        return 2.0 * amperes / (ends[0] + ends[1])  # their difference over 2 half, without loss


def current_of(name: str, motor: Motor, voltage_v: float, brushes: Brushes) -> float:
    """A that flows at the point of a figure."""
    if name.startswith("stall"):
        return _settled(lambda v: v / motor.R, voltage_v, brushes)
    if name == "peak_efficiency":
        return _settled(lambda v: _best_current(motor, v), voltage_v, brushes)
    return _settled(lambda v: _no_load_current(motor, v), voltage_v, brushes)


def figure(name: str, motor: Motor, voltage_v: float, brushes: Brushes | None) -> float:
    """A derived figure (see ``FIGURES``) at a voltage, less what the brushes drop of it."""
    of = FIGURES[name].of
    if brushes is None or name not in AT_A_VOLTAGE:
        return of(motor, voltage_v)
    left = voltage_v - brushes.drop(current_of(name, motor, voltage_v, brushes))
    if left <= 0.0:
        return 0.0
    share = left / voltage_v if name == "peak_efficiency" else 1.0
    return share * of(motor, left)


def figure_uncertainty(name: str, motor: Motor, voltage_v: float, brushes: Brushes | None) -> float:
    """What the drop's uncertainty gives the figure's (its unit), standard."""
    if brushes is None or name not in AT_A_VOLTAGE:
        return 0.0
    u = brushes.uncertainty(current_of(name, motor, voltage_v, brushes))
    around = [figure(name, motor, voltage_v + side * u, brushes) for side in (-1.0, 1.0)]
    return abs(around[1] - around[0]) / 2.0


def _settled(current: Callable[[float], float], voltage_v: float, brushes: Brushes) -> float:
    """The current that fits its own drop: it falls with the drop, which grows with it."""
    low, high = 0.0, current(voltage_v)
    for _ in range(PASSES):
        middle = 0.5 * (low + high)
        if current(max(voltage_v - brushes.drop(middle), 0.0)) > middle:
            low = middle
        else:
            high = middle
    return high


def _no_load_current(m: Motor, volts: float) -> float:
    speed = FIGURES["no_load_speed"].of(m, volts)
    return (m.B * speed + m.T0) / m.K if speed > 0.0 else volts / m.R


def _best_current(m: Motor, volts: float) -> float:
    if volts <= 0.0 or FIGURES["no_load_speed"].of(m, volts) <= 0.0:
        return volts / m.R
    s = math.sqrt((m.B * volts + m.K * m.T0) * m.R / ((m.K**2 + m.R * m.B) * volts))
    return s * volts / m.R
