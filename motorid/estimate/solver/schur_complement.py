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
    """From weighed derivatives (p, n) and (m, n), and the priors' ``precision`` (m,)."""
    free = np.flatnonzero(~held)
    rows = np.hstack([own, np.diag(np.sqrt(precision))])[free].T
    columns = np.hstack([shared, np.zeros((len(shared), len(own)))]).T
    scale = np.sqrt((rows**2).sum(axis=0))
    scale[scale == 0.0] = 1.0
    u, s, v = np.linalg.svd(rows / scale, full_matrices=False)
    known = s > ALIKE * s.max(initial=0.0)
    u, back = u[:, known], v[known].T / s[known] / scale[:, None]
    shares = u.T @ columns
    over = (columns - u @ shares).T
    follows, inverse = np.zeros((len(own), len(shared))), np.zeros((len(own), len(own)))
    follows[free] = back @ shares
    inverse[np.ix_(free, free)] = back @ back.T
    return Eliminated(gram(over, over), follows, inverse)
