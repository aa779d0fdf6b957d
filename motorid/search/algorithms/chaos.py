"""Chaotic first generations: the skew tent map (the "marquee" map of the review is this one).

Source: Mughal et al. 2018 as the review describes it; mu from ``MU`` below, because the symmetric
map (mu = .5) only shifts bits and dies at 0 after some 53 binary steps.
"""

from __future__ import annotations

import numpy as np

from motorid.estimate.results.estimate import Floats

MU = 0.7  # peak of the tent
DISCARD = 50  # steps to forget the seed


def tent(z: Floats) -> Floats:
    """One step of the map on [0, 1], any shape."""
    return np.where(z < MU, z / MU, (1.0 - z) / (1.0 - MU))


def tent_start(rng: np.random.Generator, n: int, d: int) -> Floats:
    """n consecutive points of d independently seeded orbits, shape (n, d)."""
    z = rng.random(d)
    for _ in range(DISCARD):
        z = tent(z)
    orbit = []
    for _ in range(n):
        orbit.append(z)
        z = tent(z)
    return np.array(orbit)
