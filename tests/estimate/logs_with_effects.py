"""Logs of a motor that has more than six parameters, by the compiled response; nothing stated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.motor.reading import Output, Quantity
from motorid.motor.wide import AT_REST, NAMES, WideResponse

Floats = NDArray[np.float64]

TRUTH = {"R": 3.9, "L": 8.5e-3, "K": 0.09, "J": 2.2e-5, "B": 2.4e-5, "T0": 0.017}
VOLTS, PERIOD_S, ROWS, TICKS = 24.0, 7e-4, 55, 8  # rows of a level, ticks of the run in a row
LEVELS = (0.6, -0.8, 0.45, 1.0, -0.5)  # of VOLTS
NOISE = {VOLTAGE: 2e-3, CURRENT: 3e-3, SPEED: 2e-3}  # of the largest reading
CLOCK_HZ = 1e9


def motor_with(more: Mapping[str, float]) -> Floats:
    """By ``NAMES``."""
    known = {**TRUTH, **more}
    return np.array([known.get(name, 0.0) for name in NAMES])


def run(motor: Floats, volts: Floats, period_s: float) -> Floats:
    """Current, speed and angle, (3, count), from rest."""
    response = WideResponse(period_s, volts, [Output(q) for q in Quantity])
    response.plan(motor, AT_REST)
    return response(motor, AT_REST)


@cache
def logged(*more: tuple[str, float], late_rows: int = 0) -> Capture:
    """A log of such a motor, whose current may come late by whole rows."""
    rng = np.random.default_rng(5)
    levels = VOLTS * np.repeat(LEVELS, ROWS * TICKS)
    current, speed, _ = run(motor_with(dict(more)), levels, PERIOD_S / TICKS)
    true = {VOLTAGE: levels, CURRENT: np.roll(current, late_rows * TICKS), SPEED: speed}
    channels = {}
    for name, unit in ((VOLTAGE, "V"), (CURRENT, "A"), (SPEED, "rad/s")):
        read = true[name][::TICKS]
        shown = read + rng.normal(0.0, NOISE[name] * np.abs(read).max(), len(read))
        unstated = frozenset({"delay", "filter", "aperture"})
        channels[name] = replace(Channel(name, unit, shown), undeclared=unstated)
    stamps = np.arange(len(levels) // TICKS) * PERIOD_S
    return Capture(np.rint(CLOCK_HZ * stamps).astype(np.int64), CLOCK_HZ, channels)
