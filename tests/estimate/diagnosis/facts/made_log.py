"""A log of levels of a plain motor, made in a moment, and what may be done to its rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel

MOTOR = {"R": 1.6, "L": 1.5e-3, "K": 0.052, "B": 4e-5, "J": 6e-5, "T0": 8e-3}
LEVELS = (0.0, 12.0, 24.0, 8.0, -18.0, -9.0, 0.0)  # V
LEVEL_S, PERIOD_S, FINE = 0.18, 5e-4, 10
NOISE = {VOLTAGE: 7e-3, CURRENT: 1.5e-2, SPEED: 0.2}
FULL = {VOLTAGE: 40.0, CURRENT: 30.0, SPEED: 600.0}
UNITS = {VOLTAGE: "V", CURRENT: "A", SPEED: "rad/s"}


@cache
def truth() -> Mapping[str, NDArray[np.float64]]:
    """The channels (SI), (n,) each."""
    R, L, K, B, J, T0 = MOTOR.values()
    h = PERIOD_S / FINE
    i = w = 0.0
    out = []
    for k in range(round(len(LEVELS) * LEVEL_S / h)):
        v = LEVELS[min(int(k * h / LEVEL_S + 1e-9), len(LEVELS) - 1)]
        if k % FINE == 0:
            out.append((v, i, w))
        i += h * (v - R * i - K * w) / L
        torque = K * i - B * w
        dry = min(T0, abs(J * w / h + torque)) * np.sign(J * w / h + torque)
        w += h * (torque - dry) / J
    return dict(zip((VOLTAGE, CURRENT, SPEED), np.array(out).T, strict=True))


def log(noise: float = 1.0, **other: NDArray[np.float64]) -> Capture:
    """Its log; ``other`` replaces what a channel shows."""
    rng = np.random.default_rng(7)
    series = {**truth(), **other}
    channels = {
        n: Channel(n, UNITS[n], y + noise * NOISE[n] * rng.standard_normal(len(y)))
        for n, y in series.items()
    }
    return Capture(_stamps(len(series[VOLTAGE])), 1e6, channels)


def rounded(capture: Capture, bits: int) -> Capture:
    """The same from converters of so many bits; 0: as it was."""
    if not bits:
        return capture
    channels = {}
    for name, channel in capture.channels.items():
        step = FULL[name] * 2.0 ** (1 - bits)
        channels[name] = replace(channel, raw=step * np.rint(channel.raw / step))
    return replace(capture, channels=channels)


def rows(capture: Capture, places: NDArray[np.intp]) -> Capture:
    """Some of its rows, under stamps that count them as if they were all."""
    channels = {n: replace(c, raw=c.raw[places]) for n, c in capture.channels.items()}
    return replace(capture, ticks=_stamps(len(places)), channels=channels)


def _stamps(count: int) -> NDArray[np.int64]:
    return np.rint(np.arange(count) * PERIOD_S * 1e6).astype(np.int64)
