"""Sums of products over long arrays, on one core.

A threaded BLAS wakes every core for a dot product of some ten thousand numbers, which takes longer
than the product itself, and far longer on a busy machine. These split the work below that size.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MISFIT = 4.0  # residuals in units of the scatter between neighbours: more than noise
SMALL_PRODUCT = 200_000  # multiplications that a BLAS leaves to one core


def dot(a: Floats, b: Floats) -> float:
    """Sum of a[n] b[n]."""
    return float(np.einsum("n,n->", a, b))


def square(a: Floats) -> float:
    """Sum of a[n]²."""
    return float(np.einsum("n,n->", a, a))


def project(rows: Floats, vector: Floats) -> Floats:
    """(m,) from rows (m, n) and a vector (n,)."""
    return np.asarray(np.einsum("mn,n->m", rows, vector))


def gram(a: Floats, b: Floats) -> Floats:
    """(m, p) from a (m, n) and b (p, n)."""
    m, n = a.shape
    p = len(b)
    width = max(SMALL_PRODUCT // max(m * p, 1), 1)
    total = np.zeros((m, p))
    for start in range(0, n, width):
        part = slice(start, start + width)
        total += a[:, part] @ b[:, part].T
    return total


def misfits(residual: Floats, least: float) -> bool:
    """More than noise: beyond ``least`` rms, and beyond the scatter between neighbours."""
    total = square(residual) / len(residual)
    between = square(np.diff(residual)) / (2 * len(residual))
    return total > max(MISFIT**2 * between, least**2)
