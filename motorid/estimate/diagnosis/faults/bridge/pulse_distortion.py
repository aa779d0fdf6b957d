"""Pulses of a bridge that are longer or shorter than commanded by more than is usual.

The fit has estimated by how much: it is named, and no longer moves the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorid.estimate.effects.bridge.pulse_distortion import PULSE_DISTORTION, USUAL_S
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import Suspect
from motorid.estimate.solver.problem import Solution

UNUSUAL = 4.0  # standard deviations of a usual one
SURE = 4.0  # standard deviations by noise

ONE = Instance(PULSE_DISTORTION)


def suspects(records: Sequence[MotorRecord], solution: Solution) -> list[Suspect]:
    """One, where the readings show such a time; empty: a usual one, or none that they tell."""
    sizes = [
        (float(solution.own_covariance[k][j, j]), float(solution.own[k][j]))
        for k, record in enumerate(records)
        for j, one in enumerate(record.instances)
        if one == ONE
    ]
    if not sizes:
        return []
    variance, size_s = min(sizes)  # of the bench: the capture that tells it best
    deviation_s = float(np.sqrt(max(variance, 0.0)))
    if abs(size_s) < max(UNUSUAL * USUAL_S, SURE * deviation_s):
        return []
    than = "longer" if size_s > 0.0 else "shorter"
    return [
        Suspect(
            "pulses_distorted", "bridge",
            f"the bridge's pulses are {1e9 * abs(size_s):.3g} ns {than} than the duty asks for, "
            "as delays of its driver make them that are unlike before and after a pulse; the fit "
            "allows for it",
            "compare a pulse at the bridge's input and output, and drive it by a lower PWM "
            "frequency; or measure the voltage at the motor's terminals",
            "named", allowed=True,
        )
    ]  # fmt: skip
