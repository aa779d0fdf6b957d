"""Unknowns as a vector that a search moves in: logarithms of positive ones, bounds, priors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.problem import Unknown

Floats = NDArray[np.float64]

STEP = 1e-6  # of a finite difference, relative to the parameter's scale
LOG_REACH = 14.0  # a logarithmic parameter stays within e^±14 of its start


class Coordinates:
    """The vector, and the way in and out of it."""

    def __init__(self, unknowns: Sequence[Unknown]) -> None:
        self.unknowns = tuple(unknowns)
        self.log = np.array([u.log for u in unknowns], dtype=bool)
        start = np.array([u.start for u in unknowns], dtype=np.float64)
        lower = np.array([u.lower for u in unknowns], dtype=np.float64)
        upper = np.array([u.upper for u in unknowns], dtype=np.float64)
        self.start = self.inward(start)
        with np.errstate(divide="ignore", invalid="ignore"):
            low, high = np.log(np.maximum(lower, 0.0)), np.log(upper)
        reach = np.where(self.log, LOG_REACH, np.inf)
        self.lower = np.where(self.log, np.maximum(low, self.start - reach), lower)
        self.upper = np.where(self.log, np.minimum(high, self.start + reach), upper)
        self.start = np.clip(self.start, self.lower, self.upper)
        self.step = np.array([STEP if u.log else STEP * u.scale for u in unknowns])
        self.mean = np.array([u.prior_mean for u in unknowns], dtype=np.float64)
        self.precision = np.array([u.prior_sd for u in unknowns], dtype=np.float64) ** -2.0

    def clipped(self, values: Floats) -> Floats:
        """The vector for ``values``, within the bounds."""
        return np.asarray(np.clip(self.inward(values), self.lower, self.upper))

    def apart(self, a: Floats, b: Floats) -> float:
        """Largest distance of two vectors: relative where logarithmic, else of the scale."""
        units = np.where(self.log, 1.0, self.step / STEP)
        return float(np.max(np.abs(a - b) / units, initial=0.0))

    def growth(self, before: Floats, now: Floats) -> Floats:
        """(d, 1) of derivatives between two vectors, as far as those in the values are the same."""
        return np.asarray(self.slopes(now) / self.slopes(before))[:, None]

    def slopes(self, x: Floats) -> Floats:
        """d value / d coordinate."""
        return np.exp(np.where(self.log, x, 0.0))

    def difference(self, x: Floats, j: int) -> float:
        """A finite difference's step: forward, or backward where forward leaves the bounds.

        A value may lie far above what was thought its scale.
        """
        step = float(self.step[j])
        if not self.log[j]:
            step = max(step, STEP * abs(float(x[j])))
        return -step if x[j] + step > self.upper[j] else step

    def inward(self, values: Floats) -> Floats:
        x = values.astype(np.float64, copy=True)
        x[self.log] = np.log(x[self.log])
        return x

    def outward(self, x: Floats) -> Floats:
        values = x.copy()
        values[self.log] = np.exp(x[self.log])
        return values

    def prior(self, x: Floats) -> float:
        return float(self.precision @ (x - self.mean) ** 2)

    def blocked(self, x: Floats, descent: Floats) -> NDArray[np.bool_]:
        """At a bound, and pulled further out."""
        return ((x <= self.lower) & (descent < 0)) | ((x >= self.upper) & (descent > 0))
