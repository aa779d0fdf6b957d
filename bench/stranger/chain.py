"""From a motor to a column of numbers: filters, means, converters, counters, clocks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import bessel, bilinear, butter, lfilter, lfilter_zi

Floats = NDArray[np.float64]
Rng = np.random.Generator
LEVELS = {
    "steps": (0.0, 0.5, 1.0, 0.3, -0.8, -0.4, 0.0),
    "one way": (0.0, 0.5, 1.0, 0.3, 0.7, 0.2, 0.0),
    "stairs": (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 0.8, 0.6, 0.4, 0.2, 0.0),
    "up and down": (0.0, 1.0, 1.0, 0.0, 0.0),
    "coast at the end": (0.0, 0.5, 1.0, 0.7, np.nan, np.nan),
}


def low_pass(x: Floats, dt: float, tau_s: float, kind: str) -> Floats:
    """RC: one stage; 2 RC: two equal ones; Butterworth, Bessel: 3 dB down at 1/(2 pi tau_s).

    Of a series that goes straight from tick to tick.
    """
    if kind == "RC":
        analogue = np.array([1.0]), np.array([tau_s, 1.0])
    elif kind == "2 RC":
        analogue = np.array([1.0]), np.array([tau_s**2, 2.0 * tau_s, 1.0])
    elif kind == "Bessel":
        analogue = bessel(2, 1.0 / tau_s, analog=True, norm="mag")
    else:
        analogue = butter(2, 1.0 / tau_s, analog=True)
    b, a = bilinear(*analogue, 1.0 / dt)
    return np.asarray(lfilter(b, a, x, zi=lfilter_zi(b, a) * x[0])[0])


def instants(x: Floats, dt: float, stamps: Floats, jumps: bool) -> Floats:
    """Readings at moments; of what jumps, the value since the tick before."""
    if jumps:
        return np.asarray(x[np.clip((stamps / dt + 1e-6).astype(int), 0, len(x) - 1)])
    return np.asarray(np.interp(stamps, np.arange(len(x)) * dt, x))


def means(x: Floats, dt: float, stamps: Floats, width_s: float) -> Floats:
    """Means over the time before each moment."""
    edges = np.arange(len(x)) * dt
    area = np.concatenate([[0.0], np.cumsum((x[1:] + x[:-1]) / 2.0 * dt)])
    since = np.maximum(stamps - width_s, 0.0)
    found = np.interp(stamps, edges, area) - np.interp(since, edges, area)
    return np.where(stamps > since, found / np.maximum(stamps - since, 1e-12), x[0])


def converted(x: Floats, span: float, bits: int, noise: float, rng: Rng) -> Floats:
    """By a converter over -span to span; ``noise`` in its steps."""
    step = 2.0 * span / 2**bits
    return np.asarray(np.round((x + noise * step * rng.standard_normal(len(x))) / step) * step)


def counted(angle: Floats, counts: int) -> Floats:
    """An encoder's counts."""
    return np.floor(angle * counts / (2.0 * np.pi) + 0.37)


def wave(kind: str, volts: float, tau_s: float, rate: float, rng: Rng) -> Floats:
    """V, one for each sample."""
    if kind in LEVELS:
        each = max(round(4.0 * tau_s * rate), 2)
        return np.repeat(volts * np.array(LEVELS[kind]), each)
    rest, t = np.zeros(max(round(tau_s * rate), 2)), np.arange(round(30.0 * tau_s * rate)) / rate
    if kind == "random":
        high = rng.integers(0, 2, 110) > 0
        moved = np.repeat(np.where(high, 0.9, -0.4), max(round(0.25 * tau_s * rate), 2))
    elif kind == "sweep":
        moved = 0.8 * np.sin(2.0 * np.pi * (0.03 / tau_s * t + 0.02 / tau_s**2 * t**2))
    else:  # a ramp
        moved = np.interp(t, t[-1] * np.linspace(0.0, 1.0, 5), [0.0, 1.0, 0.0, -1.0, 0.0])
    return np.concatenate([rest, volts * moved])


def driven(volts: Floats, ticks: int, phase: float | None, rng: Rng) -> Floats:
    """V of every tick, of samples that have so many. A jump comes later by ``phase`` of its sample;
    None: each by chance.
    """
    out = np.repeat(volts, ticks)
    for k in np.flatnonzero(np.diff(volts)) + 1:
        share = rng.random() if phase is None else phase
        out[k * ticks : k * ticks + round(share * ticks)] = volts[k - 1]
    return out


def clock(kind: str, count: int, period_s: float, rng: Rng) -> tuple[Floats, Floats]:
    """Moments of the readings, and what the log says of them."""
    t = np.arange(count) * period_s
    if kind == "jitter":
        t = t + rng.uniform(-0.15, 0.15, count) * period_s
    elif kind == "busy PC":
        t = np.cumsum(np.where(rng.random(count) < 0.01, rng.uniform(2, 6), 1.0) * period_s)
        t = t - t[0]
    elif kind == "4 us":
        return t, np.floor(t / 4e-6 + 0.5) * 4e-6
    return t, np.round(t, 6)
