"""Captures of a motor whose parameters are known: J dω/dt = K i − B ω − T0 sign(ω) − load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture, Channel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Plant:
    """A motor, or an axis with K = 1."""

    K: float = 0.05
    B: float = 2e-5
    J: float = 5e-5
    T0: float = 8e-3
    load: float = 0.0


def closed_loop(
    plant: Plant,
    reference: Callable[[float], float],
    gain: float,
    length_s: float,
    period_s: float = 1e-3,
    fine: int = 10,
) -> tuple[Floats, Floats, Floats]:
    """Time, current and speed while a proportional-integral loop follows ``reference`` (rad/s).

    Semi-implicit Euler at a fraction of the sample period; dry friction holds at standstill.
    """  # fmt: skip
    n = int(length_s / period_s)
    step = period_s / fine
    speed = integral = current = 0.0
    out = np.zeros((n, 2))
    for k in range(n):
        for j in range(fine):
            error = reference((k + j / fine) * period_s) - speed
            integral += 20.0 * error * step
            before, current = current, gain * (error + integral)
            if j == 0:
                out[k] = (before + current) / 2, speed  # the current steps at this instant
            push = plant.K * current - plant.load
            moved = (speed + step / plant.J * push) / (1 + step * plant.B / plant.J)
            rub = step * plant.T0 / (plant.J + step * plant.B)
            speed = float(np.sign(moved)) * max(abs(moved) - rub, 0.0)
    return np.arange(n) * period_s, out[:, 0], out[:, 1]


def capture(time_s: Floats, **channels: tuple[str, Floats] | Channel) -> Capture:
    """A capture of those channels: (unit, values) or a Channel."""
    made = {
        name: c if isinstance(c, Channel) else Channel(name, c[0], c[1])
        for name, c in channels.items()
    }
    ticks = np.rint((time_s - time_s[0]) * 1e9).astype(np.int64)
    return Capture(ticks=ticks, clock_hz=1e9, channels=made)


def steps(seconds: float, *levels: float) -> Callable[[float], float]:
    """A reference that holds each level in turn, again and again."""
    return lambda t: levels[int(t / seconds) % len(levels)]


def sweep(amplitude: float, hz: float) -> Callable[[float], float]:
    """A reference of two sines, which reverses often."""
    return lambda t: (
        amplitude * float(np.sin(2 * np.pi * hz * t) + 0.5 * np.sin(2 * np.pi * 2.7 * hz * t))
    )
