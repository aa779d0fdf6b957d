"""Readings disturbed as the rounding of another machine would disturb a fit of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motorid.capture.model import POSITION, Capture, Channel
from tests.frozen import fits
from tests.frozen.cases import Case
from tests.frozen.compare import sizes
from tests.frozen.flat import Flat

RELATIVE = 1e-13
SEEDS = (1, 2, 3)


def perturbed(capture: Capture, seed: int) -> Capture:
    """The capture with every reading off by a relative 1e-13 times a normal number.

    Readings at an end of the converter's range stay there. A position's counts stay on their grid:
    its scale is off, by one such number for all.
    """
    rng = np.random.default_rng(seed)
    channels = {name: _disturbed(c, rng) for name, c in sorted(capture.channels.items())}
    return replace(capture, channels={name: channels[name] for name in capture.channels})


def _disturbed(channel: Channel, rng: np.random.Generator) -> Channel:
    if channel.name == POSITION:
        return replace(channel, scale=channel.scale * (1 + RELATIVE * rng.standard_normal()))
    raw = np.asarray(channel.raw, dtype=np.float64)
    off = raw * RELATIVE * rng.standard_normal(len(raw))
    return replace(channel, raw=np.where(channel.saturated, raw, raw + off))


def shaken(case: Case, seed: int) -> Flat:
    """The case's answer to readings perturbed by that seed."""
    return fits.answer(case, [perturbed(capture, seed) for capture in case.captures()])


def moves(case: Case, whole: Flat) -> dict[str, float]:
    """By how much so little moves each part of a case's answer ``whole``, at most."""
    most: dict[str, float] = {}
    for seed in SEEDS:
        for name, size in sizes(whole, shaken(case, seed)).items():
            most[name] = max(most.get(name, 0.0), size)
    return most
