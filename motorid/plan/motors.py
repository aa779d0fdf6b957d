"""The motors that a plan must serve: not only the one on the label, but all that it may stand for.

Every parameter lies in a range. The plan is tried on the middle of all ranges and on eight corners,
chosen so that each pair of parameters takes all four combinations of low and high equally often
(an orthogonal array of strength two, after Plackett and Burman).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from motorid.errors import RigError
from motorid.estimate.results.estimate import PARAMETERS, Estimate
from motorid.motor.parameters import Motor
from motorid.rig import Nameplate

Range = tuple[float, float]
Spread = Mapping[str, Range]

TOLERANCE = {"R": 1.3, "L": 2.0, "K": 1.3, "J": 3.0}  # factors that a label may be wrong by
FRICTION_SHARE = {"B": (0.05, 1.0), "T0": (0.3, 1.5)}  # of the torque that the label lets expect
SHORT_S = 3e-4  # L/R of a small motor, where its label names no inductance
NO_LOAD = 0.05  # no-load current over stall current, where the label does not name it
DEVIATIONS = 2.0  # standard ones, of what a first capture told
# one row a parameter, in the order of PARAMETERS; one column a corner
CORNERS = np.array(
    [[1 if bin(corner & mask).count("1") % 2 else -1 for corner in range(8)]
     for mask in (1, 2, 4, 3, 5, 7)]
)  # fmt: skip


def middle(spread: Spread) -> Motor:
    """The geometric mean of all ranges."""
    return Motor.of({n: float(np.sqrt(spread[n][0] * spread[n][1])) for n in PARAMETERS})


def motors(spread: Spread) -> tuple[Motor, ...]:
    """The middle, then the corners; the middle alone where nothing is uncertain."""
    if all(low == high for low, high in spread.values()):
        return (middle(spread),)
    corners = [
        Motor.of({n: spread[n][int(side > 0)] for n, side in zip(PARAMETERS, column, strict=True)})
        for column in CORNERS.T
    ]
    return (middle(spread), *corners)


def of_nameplate(plate: Nameplate) -> dict[str, Range]:
    """Ranges about a label's figures. Raises RigError where it names too little."""
    R, K, J = plate.resistance_ohm, plate.torque_constant_nm_a, plate.inertia_kg_m2
    volts = plate.voltage_v
    if R is None or K is None or J is None or volts is None:
        keys = ("resistance_ohm", "torque_constant_nm_a", "inertia_kg_m2", "voltage_v")
        lacking = [key for key in keys if getattr(plate, key) is None]
        raise RigError(
            f"the rig's nameplate lacks {' and '.join(lacking)}: give it, roughly, or plan from "
            "a first run with --capture"
        )
    values = {"R": R, "L": plate.inductance_h or SHORT_S * R, "K": K, "J": J}
    found = {n: (values[n] / f, values[n] * f) for n, f in TOLERANCE.items()}
    torque = K * (plate.no_load_current_a or NO_LOAD * volts / R)
    units = {"B": torque * K / volts, "T0": torque}
    return found | {
        n: (low * units[n], high * units[n]) for n, (low, high) in FRICTION_SHARE.items()
    }


def of_estimate(estimate: Estimate, otherwise: Spread) -> dict[str, Range]:
    """Two standard uncertainties to either side of what a first run told, where it told it."""
    found = dict(otherwise)
    for name in PARAMETERS:
        p = estimate.parameters[name]
        if p.value is not None and p.total is not None and p.value > 0:
            factor = float(np.exp(min(DEVIATIONS * p.total / p.value, 2.0)))
            found[name] = (p.value / factor, p.value * factor)
    return found
