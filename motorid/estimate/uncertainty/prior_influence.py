"""How much of a parameter's variance is what was supposed of a nuisance before any data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.dense_products import project
from motorid.estimate.solver.problem import Linearised, Solution
from motorid.estimate.uncertainty.covariance import covariance_of

Floats = NDArray[np.float64]


def variances(solution: Solution, records: Sequence[MotorRecord], name: str) -> Floats:
    """(p,): of the shared parameters in search coordinates, by the prior of nuisance ``name``.

    A prior's mean that were off by its deviation would move them by the root of it.
    """
    covariance = covariance_of(solution.information)
    total = np.zeros(len(covariance))
    for record, line in zip(records, solution.records, strict=True):
        for j, unknown in enumerate(record.unknowns):
            if unknown.name == name:
                total += (covariance @ pull(line, j)) ** 2
    return total


def pull(line: Linearised, j: int) -> Floats:
    """Score (p,) of the parameters if nuisance ``j`` were off its prior by a standard deviation."""
    own, within = line.own, line.own_information
    follows = np.linalg.lstsq(within, np.eye(len(within))[j], rcond=1e-14)[0]
    return np.asarray(-project(line.shared.T, own @ follows) * np.sqrt(line.own_precision[j]))
