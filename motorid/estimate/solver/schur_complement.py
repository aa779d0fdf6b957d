"""The nuisances of a record eliminated: how they follow the shared unknowns, and what is left.

By the sums that a search has anyway. Where nuisances are nearly alike (a loss and the levels of a
source) and explain nearly all, sums have too few digits: then by the derivatives themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.solver.dense_products import gram
from motorid.estimate.solver.normal_equations import Normal
from motorid.estimate.solver.problem import bounded_inverse

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

LOST = 1e-6  # of an information, that nuisances may leave before its digits are in doubt
INFLATED = 1e8  # times the variance of a nuisance alone: the same for what nuisances are alike
STRETCH = 512  # rows turned into a triangle at once
ALIKE = 1e-12  # of the largest singular value: nuisances that differ by less are one


@dataclass(frozen=True)
class Eliminated:
    """Information ``left`` (p, p) of the shared unknowns, the nuisances' step ``follows`` (m, p)
    for a step of each, and their own covariance ``inverse`` (m, m), the shared ones held.
    """

    left: Floats
    follows: Floats
    inverse: Floats

    def doubtful(self, normal: Normal) -> bool:
        """Some information is what little is left of a difference, or nuisances are all but one."""
        little = np.diag(self.left) < LOST * np.diag(normal.ss)
        return bool(little.any() or (np.diag(self.inverse) * np.diag(normal.oo) > INFLATED).any())


def by_sums(normal: Normal, held: Bools) -> Eliminated:
    """From products of derivatives; ``held`` (m,) nuisances stay where they are."""
    inverse = bounded_inverse(normal.oo, held)
    follows = inverse @ normal.so.T
    return Eliminated(normal.ss - normal.so @ follows, follows, inverse)


def by_rows(shared: Floats, own: Floats, precision: Floats, held: Bools) -> Eliminated:
    """From weighed derivatives (p, n) and (m, n), and the priors' ``precision`` (m,).

    Of all rows their triangle alone is needed: what turns them into it keeps every product.
    """
    free = np.flatnonzero(~held)
    ends = np.diag(np.sqrt(precision))[free]
    scale = np.sqrt((own[free] ** 2).sum(axis=1) + precision[free])
    scale[scale == 0.0] = 1.0
    rows = np.vstack([own[free] / scale[:, None], shared]).T
    prior = np.hstack([(ends / scale[:, None]).T, np.zeros((len(own), len(shared)))])
    triangle = _triangle(np.vstack([rows, prior]))
    m = len(free)
    turned = triangle[:, m:]
    u, s, v = np.linalg.svd(triangle[:, :m], full_matrices=False)
    known = s > ALIKE * s.max(initial=0.0)
    u, back = u[:, known], v[known].T / s[known] / scale[:, None]
    shares = u.T @ turned
    over = (turned - u @ shares).T
    follows, inverse = np.zeros((len(own), len(shared))), np.zeros((len(own), len(own)))
    follows[free] = back @ shares
    inverse[np.ix_(free, free)] = back @ back.T
    return Eliminated(gram(over, over), follows, inverse)


def _triangle(rows: Floats) -> Floats:
    """R of the rows' QR, (k, columns) of at most as many rows; stretch by stretch, in the cache."""
    width = rows.shape[1]
    step = max(STRETCH, 4 * width)
    found = [np.linalg.qr(rows[a : a + step], mode="r") for a in range(0, len(rows), step)]
    return np.asarray(np.linalg.qr(np.vstack(found), mode="r"))
