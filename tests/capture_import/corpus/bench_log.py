"""The log that every file of the corpus holds: steps and a coast of a known motor, in SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from bench.foreign.plant import Motor, turn

Floats = NDArray[np.float64]
PERIOD_S, LENGTH_S = 2e-3, 1.2
NOISE = {"voltage": 0.01, "current": 5e-3, "speed": 0.1}
RPM = 60.0 / (2.0 * np.pi)


def _drive(time_s: float, speed: float) -> float | None:
    if time_s > 0.9:
        return None
    return 0.0 if time_s < 0.04 else 6.0 if time_s < 0.3 else 12.0 if time_s < 0.6 else -6.0


@cache
def log() -> Mapping[str, Floats]:
    """``time``, ``voltage``, ``current``, ``speed`` and ``position``, (rows,) each."""
    true, rng = turn(Motor(), _drive, LENGTH_S), np.random.default_rng(1)
    time = np.arange(0.0, LENGTH_S, PERIOD_S)
    read = {"voltage": true.volts, "current": true.current, "speed": true.speed}
    found = {
        name: true.at(values, time) + NOISE[name] * rng.standard_normal(len(time))
        for name, values in read.items()
    }
    return {"time": time, **found, "position": true.at(true.angle, time)}


def columns(**scales: float) -> Floats:
    """Those quantities of the log in units of ``1/scale``, (rows, quantities)."""
    return np.column_stack([log()[name] * scale for name, scale in scales.items()])


def text(
    head: str, table: Floats, *, separator: str = ",", decimal: str = ".", digits: int = 7
) -> str:
    """A text table; ``head`` with its line ends."""
    lines = (separator.join(f"{x:.{digits}g}".replace(".", decimal) for x in row) for row in table)
    return head + "\n".join(lines) + "\n"


def lines(rows: Sequence[str]) -> str:
    """Text of those lines."""
    return "\n".join(rows) + "\n"
