"""Faults of a measuring chain put into a capture that the simulated rig gave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from motorid.capture.model import CURRENT, POSITION, Capture, Channel
from motorid.program import StepKind

Floats = NDArray[np.float64]


def _requantised(channel: Channel, values: Floats) -> Channel:
    """The channel with other readings, rounded to its counts and within its converter's range."""
    raw = np.rint(values / channel.scale + channel.offset)
    if np.isfinite(channel.raw_max):
        raw = np.clip(raw, channel.raw_min, channel.raw_max)
    return replace(channel, raw=raw.astype(np.int64))


def changed(capture: Capture, name: str, values: Floats) -> Capture:
    """The capture with other readings of one channel."""
    return replaced(capture, _requantised(capture.channels[name], values))


def replaced(capture: Capture, channel: Channel) -> Capture:
    """The capture with another channel in the place of one."""
    return replace(
        capture, channels={**capture.channels, channel.name: channel}, sha256="", path=""
    )


def offset(capture: Capture, amount: float, name: str = CURRENT) -> Capture:
    """A channel whose zero is off by ``amount`` (SI)."""
    return changed(capture, name, capture.channels[name].values + amount)


def offset_driven(capture: Capture, amount: float) -> Capture:
    """A current whose zero is off by ``amount`` while the bridge connects the motor."""
    steps = capture.program.steps if capture.program else ()
    driven = np.zeros(len(capture))
    for phase in capture.phases:
        driven[capture.ticks > phase.tick] = steps[phase.index].kind != StepKind.COAST
    return changed(capture, CURRENT, capture.channels[CURRENT].values + amount * driven)


def lag(capture: Capture, name: str, samples: int) -> Capture:
    """A channel that comes so many samples late."""
    values = capture.channels[name].values
    return changed(capture, name, np.concatenate([np.full(samples, values[0]), values[:-samples]]))


def low_pass(capture: Capture, tau_s: float, name: str = CURRENT) -> Capture:
    """A first-order filter before the converter; the readings are taken to join by straight lines.

    The filter takes noise away, and the converter adds its own again.
    """
    values, h = capture.channels[name].values, capture.period_s / tau_s
    a = np.exp(-h)
    late, now = (1 - a) / h - a, 1 - (1 - a) / h
    out = np.empty_like(values)
    out[0] = values[0]
    for n in range(1, len(values)):
        out[n] = a * out[n - 1] + late * values[n - 1] + now * values[n]
    noise = np.random.default_rng(6).standard_normal(len(out)) * capture.channels[name].noise
    return changed(capture, name, out + noise)


def averaged(capture: Capture, counts: float, name: str = CURRENT) -> Capture:
    """A recursive average in firmware, of which a new reading counts that share."""
    values = capture.channels[name].values
    out, _ = lfilter([counts], [1.0, counts - 1.0], values, zi=[values[0] * (1.0 - counts)])
    return changed(capture, name, out)


def mean_of_last(capture: Capture, count: int, name: str = CURRENT) -> Capture:
    """The mean of so many last readings, in firmware."""
    values = capture.channels[name].values
    before = np.concatenate([np.full(count - 1, values[0]), values])
    return changed(capture, name, np.convolve(before, np.full(count, 1.0 / count), "valid"))


def clip(capture: Capture, limit: float, name: str = CURRENT) -> Capture:
    """A channel that shows no more than ``limit`` (SI) in size; the converter's noise follows."""
    channel = capture.channels[name]
    values = channel.values
    noise = np.random.default_rng(5).standard_normal(len(values)) * channel.noise
    inside = np.abs(values) < limit
    return changed(capture, name, np.where(inside, values, np.sign(values) * limit + noise))


def reversed_(capture: Capture, name: str) -> Capture:
    """A channel of the other sign."""
    return changed(capture, name, -capture.channels[name].values)


def scaled(capture: Capture, name: str, factor: float) -> Capture:
    """A channel whose scale is wrong by ``factor``; its declared noise and steps come with it."""
    c = capture.channels[name]
    return replaced(
        capture,
        replace(
            c, scale=factor * c.scale, resolution=factor * c.resolution, noise=factor * c.noise,
            offset_uncertainty=factor * c.offset_uncertainty,
        ),
    )  # fmt: skip


def dropped(capture: Capture, seed: int, times: int, longest: int) -> Capture:
    """Samples that are missing while the time stamps go on as if none were."""
    rng = np.random.default_rng([seed, 11])
    keep = np.ones(len(capture), dtype=bool)
    moving = _moving(capture)
    for place in rng.choice(moving, times, replace=False):
        keep[place : place + int(rng.integers(1, longest + 1))] = False
    channels = {n: replace(c, raw=np.asarray(c.raw)[keep]) for n, c in capture.channels.items()}
    ticks = capture.ticks[: int(keep.sum())]
    return replace(capture, ticks=ticks, channels=channels, sha256="", path="")


def held(capture: Capture, seed: int, share: float, longest: int, name: str = CURRENT) -> Capture:
    """A converter that repeats its last reading, for up to ``longest``; ``share`` in all."""
    rng = np.random.default_rng([seed, 12])
    raw = np.array(capture.channels[name].raw)
    left = int(share * len(raw))
    while left > 0:
        start = int(rng.integers(1, len(raw) - longest))
        length = int(rng.integers(max(longest // 2, 2), longest + 1))
        raw[start : start + length] = raw[start]
        left -= length
    return replaced(capture, replace(capture.channels[name], raw=raw))


def lost_counts(capture: Capture, seed: int, times: int, counts: int) -> Capture:
    """An encoder that misses up to ``counts`` counts so many times while the shaft turns."""
    rng = np.random.default_rng([seed, 13])
    channel = capture.channels[POSITION]
    raw = np.array(channel.raw, dtype=np.int64)
    way = np.sign(np.gradient(channel.values))
    for place in rng.choice(_moving(capture), times, replace=False):
        raw[place:] -= int(way[place]) * int(rng.integers(counts // 2 + 1, counts + 1))
    return replaced(capture, replace(channel, raw=raw))


def slow_edges(capture: Capture, counts_per_s: float) -> Capture:
    """An encoder whose counter follows no more than so many counts a second."""
    channel = capture.channels[POSITION]
    most = counts_per_s * capture.period_s
    steps = np.diff(np.asarray(channel.raw, dtype=np.float64), prepend=float(channel.raw[0]))
    raw = np.asarray(channel.raw)[0] + np.cumsum(np.clip(steps, -most, most))
    return replaced(capture, replace(channel, raw=np.rint(raw).astype(np.int64)))


def decimated(capture: Capture, factor: int = 2) -> Capture:
    """Every so many-th sample: faults are put in at the finer rate."""
    channels = {n: replace(c, raw=np.asarray(c.raw)[::factor]) for n, c in capture.channels.items()}
    return replace(capture, ticks=capture.ticks[::factor], channels=channels, sha256="", path="")


def _moving(capture: Capture) -> NDArray[np.intp]:
    """Samples at which the shaft turns at a tenth of its top speed at least."""
    speed = np.abs(np.gradient(capture.channels[POSITION].values))
    smooth = np.convolve(speed, np.ones(21) / 21, "same")
    found = np.flatnonzero(smooth > 0.1 * smooth.max())
    return found[(found > 100) & (found < len(speed) - 100)]
