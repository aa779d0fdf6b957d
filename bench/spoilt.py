"""Captures that no motor gives: channels swapped, scaled, shuffled, or of another run. Seeded.

Each of ``SPOILS`` takes a capture, another one and a random generator. None of its captures may end
in a fit that calls its parameters estimated, save those of which no residual can tell: a scale.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, VOLTAGE, Capture, Channel
from tests.frozen.cases import CASES, Case

Floats = NDArray[np.float64]
Spoil = Callable[[Capture, Capture, np.random.Generator], Capture]

BASES = (
    "sim", "sim-re35", "sim-qube", "sim-pittman", "sim-line", "emulated-uno", "diode-decay",
    "fast-decay", "thermal-figures", "supply-sense-by-duty", "log-steps", "log-position",
    "log-means", "log-random-stamps", "log-drop-outs",
)  # fmt: skip
CASE_OF: Mapping[str, Case] = {case.name: case for case in CASES}


@dataclass(frozen=True)
class Spoilt:
    """One capture that no motor gave; ``base`` and ``spoil`` say how it was made."""

    base: str
    spoil: str
    capture: Capture

    @property
    def name(self) -> str:
        """Of both."""
        return f"{self.base}: {self.spoil}"


def with_readings(capture: Capture, name: str, values: Floats) -> Capture:
    """Other readings (SI) of one channel, as a float column; its converter has no ends."""
    channel = replace(
        capture.channels[name], raw=values, scale=1.0, offset=0.0, raw_min=-np.inf, raw_max=np.inf
    )
    return with_channel(capture, channel)


def with_channel(capture: Capture, channel: Channel) -> Capture:
    """One channel in the place of that of its name."""
    channels = {**capture.channels, channel.name: channel}
    return replace(capture, channels=channels, sha256="", content_sha256="", path="")


def volts(capture: Capture) -> str:
    """The voltage's channel."""
    return next(name for name in (VOLTAGE, SUPPLY) if name in capture.channels)


def motion(capture: Capture) -> str:
    """The motion's channel."""
    return next(name for name in (POSITION, SPEED) if name in capture.channels)


def swapped(a: Callable[[Capture], str], b: Callable[[Capture], str]) -> Spoil:
    """The readings of two channels change places."""

    def spoil(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
        first, second = a(capture), b(capture)
        one, other = capture.channels[first].values, capture.channels[second].values
        return with_readings(with_readings(capture, first, other), second, one)

    return spoil


def scaled(of: Callable[[Capture], str], factor: float) -> Spoil:
    """A channel in a wrong unit."""

    def spoil(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
        name = of(capture)
        return with_readings(capture, name, factor * capture.channels[name].values)

    return spoil


def shuffled(of: Callable[[Capture], str]) -> Spoil:
    """A channel's readings in any order."""

    def spoil(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
        name = of(capture)
        return with_readings(capture, name, rng.permutation(capture.channels[name].values))

    return spoil


def all_shuffled(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
    """All samples in any order, each whole."""
    order = rng.permutation(len(capture))
    for name, channel in capture.channels.items():
        capture = with_readings(capture, name, channel.values[order])
    return capture


def backwards(of: Callable[[Capture], str] | None) -> Spoil:
    """One channel, or all of them, against the time."""

    def spoil(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
        for name in [of(capture)] if of else list(capture.channels):
            capture = with_readings(capture, name, capture.channels[name].values[::-1].copy())
        return capture

    return spoil


def negated(of: Callable[[Capture], str]) -> Spoil:
    """A channel of the wrong sign."""
    return scaled(of, -1.0)


def foreign(of: Callable[[Capture], str]) -> Spoil:
    """A channel of another run, begun where it may, as long as this one."""

    def spoil(capture: Capture, other: Capture, rng: np.random.Generator) -> Capture:
        name = of(capture)
        kind = {volts(capture): volts, motion(capture): motion}.get(name)
        values = other.channels[kind(other) if kind else name].values
        return with_readings(capture, name, np.resize(values, len(capture)))

    return spoil


def rolled(of: Callable[[Capture], str]) -> Spoil:
    """A channel that is late by a fifth to a half of the run, its end put before its begin."""

    def spoil(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
        name = of(capture)
        late = int(len(capture) * rng.uniform(0.2, 0.5))
        return with_readings(capture, name, np.roll(capture.channels[name].values, late))

    return spoil


def noise(of: Callable[[Capture], str]) -> Spoil:
    """A sensor that is not connected."""

    def spoil(capture: Capture, _: Capture, rng: np.random.Generator) -> Capture:
        name = of(capture)
        size = float(np.nanstd(capture.channels[name].values))
        return with_readings(capture, name, size * rng.standard_normal(len(capture)))

    return spoil


def current(capture: Capture) -> str:
    """The current's channel."""
    assert CURRENT in capture.channels
    return CURRENT


OF = {"voltage": volts, "current": current, "motion": motion}
SPOILS: Mapping[str, Spoil] = {
    "voltage and current swapped": swapped(volts, current),
    "current and motion swapped": swapped(current, motion),
    "voltage and motion swapped": swapped(volts, motion),
    "all shuffled": all_shuffled,
    "all backwards": backwards(None),
    **{f"{name} shuffled": shuffled(of) for name, of in OF.items()},
    **{f"{name} backwards": backwards(of) for name, of in OF.items()},
    **{f"{name} negated": negated(of) for name, of in OF.items()},
    **{f"{name} of another run": foreign(of) for name, of in OF.items()},
    **{f"{name} rolled": rolled(of) for name, of in OF.items()},
    **{f"{name} noise": noise(of) for name, of in OF.items()},
}
SCALED: Mapping[str, Spoil] = {  # what a nameplate alone can tell
    **{f"{name} times 1000": scaled(of, 1e3) for name, of in OF.items()},
    **{f"{name} times root 1000": scaled(of, math.sqrt(1e3)) for name, of in OF.items()},
}


def drawn(seed: int, count: int, spoils: Mapping[str, Spoil] = SPOILS) -> Iterator[Spoilt]:
    """Captures at random: every spoil in turn, each of a base that is drawn."""
    rng = np.random.default_rng(seed)
    names = list(spoils)
    for k in range(count):
        spoil = names[k % len(names)]
        base, other = (str(name) for name in rng.choice(BASES, 2, replace=False))
        yield made(base, spoil, other, rng)


def made(base: str, spoil: str, other: str, rng: np.random.Generator) -> Spoilt:
    """One of them."""
    capture, foreigner = (CASE_OF[name].captures()[0] for name in (base, other))
    return Spoilt(base, spoil, {**SPOILS, **SCALED}[spoil](capture, foreigner, rng))
