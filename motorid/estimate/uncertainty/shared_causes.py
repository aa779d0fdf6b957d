"""Unknowns that every capture has, but that are one cause: a motor's brushes, its winding.

The fit gives each capture its own, with the same prior, so that three captures would seem to know
it by the root of three better than that prior does. What is lacking is carried to the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.brush_and_heating import BENT, DIODES, DROP, TURN, WARMING
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.prior_influence import pull

Floats = NDArray[np.float64]

ONE = (DROP, BENT, WARMING, DIODES, "current_offset", "voltage_offset", "current_late")


def shifts(solution: Solution, records: Sequence[MotorRecord]) -> list[Floats]:
    """What each such cause adds to the parameters' noise, (p,) each, in search coordinates."""
    inverse = covariance_of(solution.information)
    pulls: dict[str, list[Floats]] = {}
    for record, line in zip(records, solution.records, strict=True):
        for j, unknown in enumerate(record.unknowns):
            if np.isfinite(unknown.prior_sd) and unknown.name.startswith((*ONE, TURN)):
                pulls.setdefault(unknown.name, []).append(inverse @ pull(line, j))
    out = []
    for moved in pulls.values():
        together, apart = np.sum(moved, axis=0), np.sum(np.square(moved), axis=0)
        out.append(np.sign(together) * np.sqrt(np.maximum(together**2 - apart, 0.0)))
    return out
