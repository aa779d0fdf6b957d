"""How much an effect's pull on the residuals scatters, against white residuals of one deviation.

The pull is the sum of c·r, with c the change of the readings by the effect, cleared of what
parameters and nuisances explain. Its variance is that of white residuals, c'c, where each reading
is off by chance alone. What no model holds (a wide code of a converter, a voltage between the
readings of a log) leaves residuals that stay off for a while, or large ones at few readings. The
variance is told by the residuals that are left after the effect: by the sums of c·r over STRETCHES
stretches that tell as much of the effect each, and reading by reading (White's covariance, 1980;
sums over clusters, Liang and Zeger 1986). A true effect leaves none of it to them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STRETCHES = 8  # of a record: each longer than what stays off, and enough for a variance


def pull_scatter(
    changes: Sequence[Floats], residuals: Sequence[Floats], unseen: Sequence[float] = ()
) -> float:
    """Variance of the pull over that of white residuals, 1 at least.

    ``changes`` and ``residuals``: (n,) a record, each reading divided by its deviation. ``unseen``:
    pulls by one standard deviation each of errors that all residuals share, and so do not show.
    """
    white = sum(float(change @ change) for change in changes)
    if not white > 0.0:
        return 1.0
    size = sum(float(c @ r) for c, r in zip(changes, residuals, strict=True)) / white
    single = joint = 0.0
    for change, residual in zip(changes, residuals, strict=True):
        pulls = change * (residual - size * change)
        single += float(pulls @ pulls)
        sums = np.add.reduceat(pulls, _stretches(change))
        joint += float(sums @ sums) * STRETCHES / (STRETCHES - 1)
    return max(single / white, joint / white, 1.0) + sum(pull**2 for pull in unseen) / white


def _stretches(change: Floats) -> NDArray[np.intp]:
    """Where each stretch begins: readings in their order, of the same sum of squares."""
    told = np.cumsum(change**2)
    begins = np.searchsorted(told, told[-1] * np.arange(1, STRETCHES) / STRETCHES) + 1
    return np.unique(np.concatenate(([0], np.minimum(begins, len(change) - 1))))
