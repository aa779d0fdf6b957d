"""What readings are worth where the residuals wander slowly.

A short filter whitens what neighbours share. A wander over hundreds of samples (a voltage that
jitters and a position that adds it up, friction that is not quite Coulomb's) is left: many readings
are then worth few. Means over an eighth of a stretch show it: by noise alone their squares are as
large as their weights say.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import square

Floats = NDArray[np.float64]

BATCHES = 8  # of a stretch
SHORTEST = 128  # samples of a stretch that can show a wander
SURE = 3.0  # standard errors by which it must stand out


def excess(residuals: Sequence[Floats], roots: Sequence[Floats]) -> float:
    """Variance of the stretches' batch means over that of white noise; 1 where it may be noise.

    ``residuals`` are weighed by ``roots`` already, (n,) each.
    """
    long = [(r, w) for r, w in zip(residuals, roots, strict=True) if len(r) >= SHORTEST]
    weight = sum(square(w) for _, w in long)
    variance = sum(square(r) for r, _ in long) / weight if weight else 0.0
    if not variance:
        return 1.0
    means = np.concatenate([_means(r, w) for r, w in long])
    found = square(means) / len(means) / variance
    return float(found) if found > 1.0 + SURE * np.sqrt(2.0 / len(means)) else 1.0


def _means(residual: Floats, roots: Floats) -> Floats:
    """Weighted sums over batches, each of the standard deviation of one reading if white."""
    edges = np.linspace(0, len(residual), BATCHES + 1).astype(int)[:-1]
    sums = np.add.reduceat(roots * residual, edges)
    return np.asarray(sums / np.sqrt(np.maximum(np.add.reduceat(roots**2, edges), 1e-300)))
