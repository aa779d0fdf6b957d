"""The free parameters of a motor as the search sees them: bounds, scales and start values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.problem import Solution, Unknown

TOLD = 1e-3  # standard deviation of the logarithm of an inductance that readings do not tell
SHORTEST_ELECTRICAL = 1e-3  # L/R in sample periods: below it the data know no inductance


def unknowns_of(
    records: Sequence[MotorRecord], free: Sequence[str], start: Mapping[str, float]
) -> list[Unknown]:
    """The free parameters with their bounds, scales and start values."""
    torque, speed = typical(records, start)
    period = min(record.timeline.period_s for record in records)
    scales = {"B": torque / speed, "T0": torque}
    out = []
    for name in free:
        if name in scales:
            out.append(Unknown(name, start[name], lower=0.0, scale=scales[name]))
        elif name == "L":
            least = SHORTEST_ELECTRICAL * start["R"] * period
            found = Unknown(name, max(start[name], 2 * least), lower=least, log=True)
            told = records[0].foretold
            out.append(found if told is None else _as_told(found, told.inductance_h))
        elif name not in PARAMETERS:
            out.append(records[0].unknown(name, start[name]))
        else:
            out.append(Unknown(name, start[name], lower=0.0, log=True))
    return out


def _as_told(inductance: Unknown, inductance_h: float) -> Unknown:
    """As good as held there: what is not known of it, the instruments' budget has."""
    mean = float(np.log(inductance_h))
    return replace(inductance, start=inductance_h, prior_mean=mean, prior_sd=TOLD)


def held_values(fix: Mapping[str, float], without: Sequence[str]) -> dict[str, float]:
    """Of the parameters that are not searched: as given, or 0 where left out of the model."""
    return {**dict.fromkeys(without, 0.0), **fix}


def searched(held: Mapping[str, float]) -> list[str]:
    """The parameters that are not held, in their order."""
    return [name for name in PARAMETERS if name not in held]


def typical(records: Sequence[MotorRecord], start: Mapping[str, float]) -> tuple[float, float]:
    """A torque (N·m) and a speed (rad/s) of these captures."""
    currents, speeds = [], []
    for record in records:
        speeds.append(float(np.abs(record.volts).max()) / start["K"])
        for m in record.measured:
            if m.block.name == CURRENT:
                currents.append(float(np.median(np.abs(m.values[record.driven[m.keep]]))))
    torque = start["K"] * max(currents, default=0.0) or start["T0"] or 1.0
    return torque, max(speeds) or 1.0


def merged(start: Mapping[str, float], solution: Solution) -> dict[str, float]:
    """Start values with the solution's where it has them."""
    found = zip(solution.unknowns, solution.values, strict=True)
    return {**start, **{u.name: float(v) for u, v in found}}
