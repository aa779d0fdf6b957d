"""How much of a parameter's variance is what was supposed of a nuisance before any data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.algebra import gram
from motorid.estimate.record import MotorRecord
from motorid.estimate.solution import Solution
from motorid.estimate.uncertainty import covariance_of

Floats = NDArray[np.float64]


def variances(solution: Solution, records: Sequence[MotorRecord], name: str) -> Floats:
    """(p,): of the shared parameters in search coordinates, by the prior of nuisance ``name``.

    A prior's mean that were off by its deviation would move them by the root of it.
    """
    covariance = covariance_of(solution.information)
    total = np.zeros(len(covariance))
    for record, line in zip(records, solution.records, strict=True):
        names = [u.name for u in record.unknowns]
        if name not in names:
            continue
        own, place = line.own.T, names.index(name)
        inverse = covariance_of(gram(own, own) + np.diag(line.own_precision))
        crossed = covariance @ gram(line.shared.T, own) @ inverse
        total += crossed[:, place] ** 2 * line.own_precision[place]
    return total
