"""Normal equations of a record, its nuisances apart: sums that outlive a change of the noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import gram

Floats = NDArray[np.float64]


@dataclass
class Normal:
    """Products of derivatives (s shared, o own), and with the residuals (g), weighed."""

    ss: Floats
    so: Floats
    oo: Floats
    gs: Floats
    go: Floats

    @property
    def finite(self) -> bool:
        """No derivative or residual has overflowed."""
        return all(
            np.isfinite(part).all() for part in (self.ss, self.so, self.oo, self.gs, self.go)
        )


@dataclass
class Products:
    """Of derivatives, not weighed, by block: (b, p, p), (b, p, m) and (b, m, m)."""

    ss: Floats
    so: Floats
    oo: Floats

    def weighed(self, weights: Floats) -> tuple[Floats, Floats, Floats]:
        """Summed over blocks of these weights (b,)."""
        ss, so, oo = (np.einsum("b,bij->ij", weights, p) for p in (self.ss, self.so, self.oo))
        return ss, so, oo


def products(shared: Floats, own: Floats, lengths: Sequence[int]) -> Products:
    """Of derivatives (p, n) and (m, n) whose rows hold blocks of such lengths."""
    edges = np.cumsum([0, *lengths])
    parts = [(shared[:, a:b], own[:, a:b]) for a, b in pairwise(edges)]
    p, m = len(shared), len(own)
    return Products(
        np.array([gram(a, a) for a, _ in parts]).reshape(len(parts), p, p),
        np.array([gram(a, c) for a, c in parts]).reshape(len(parts), p, m),
        np.array([gram(c, c) for _, c in parts]).reshape(len(parts), m, m),
    )
