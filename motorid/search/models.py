"""Models beyond the six parameters that a search can fit to captures: what they add, and bounds.

Quadratic load, the review's (17), (18): torque T0 sign(w) + B w + T_lc w |w|, so that its T_la is
T0 and its T_lb is B. Two masses, (19) to (21) behind the motor's own equations: J1 at the motor
carries B, a spring Ks with damping b carries J2; there is no Coulomb friction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from motorid.errors import UsageError, nearest
from motorid.estimate.model.capture_model import MotorRecord
from motorid.motor.batch import DRIVEN_TWO_MASS, Model, quadratic
from motorid.search import captures
from motorid.search.bounds import Box

PARTS = 0.02, 10.0  # of the inertia that the closed form sees: each mass
DAMPING = 1e-3, 1.0  # of the spring's critical damping, of the order of magnitude
SLOWEST, FASTEST = 2.0, 0.1  # swings of the spring: in the whole record, in a sample


@dataclass(frozen=True)
class Extended:
    """A model by its name: its batch response under this project's names, and what it adds.

    ``absent``: parameters of the six that it lacks. ``units`` and ``meaning`` of the added ones.
    """

    name: str
    equations: str
    batch: Model
    units: Mapping[str, str]
    absent: tuple[str, ...] = ()


QUADRATIC_LOAD = Extended(
    "quadratic-load",
    "v = R i + L di/dt + K w; J dw/dt = K i - T_la sign(w) - T_lb w - T_lc w |w|, "
    "with T_la as T0 and T_lb as B",
    replace(quadratic(), parameters=("R", "L", "K", "J", "T0", "B", "T_lc")),
    {"T_lc": "N·m·s²/rad²"},
)
TWO_MASSES = Extended(
    "two-masses",
    "v = R i + L di/dt + K w; J1 dw/dt = K i - B w - T; J2 dw2/dt = T; "
    "T = Ks (angle - angle2) + b (w - w2)",
    DRIVEN_TWO_MASS,
    {"J1": "kg·m²", "J2": "kg·m²", "Ks": "N·m/rad", "b": "N·m·s/rad"},
    absent=("J", "T0"),
)
LINEAR = "linear"  # the six parameters
EXTENDED = {model.name: model for model in (QUADRATIC_LOAD, TWO_MASSES)}
NAMES = (LINEAR, *EXTENDED)


def get(name: str) -> Extended:
    """The model of that name. Raises UsageError that names the nearest."""
    if name not in EXTENDED:
        raise UsageError(
            f'there is no model "{name}"{nearest(name, NAMES)}; the models are {", ".join(NAMES)}'
        )
    return EXTENDED[name]


def box(
    records: Sequence[MotorRecord],
    start: Mapping[str, float],
    free: Sequence[str],
    samples: int,
) -> Box:
    """Bounds of the free parameters in SI, by their logarithms, about the closed form's values."""
    six = captures.box(records, start, ("R", "L", "K", "B", "J", "T0"))
    spans = dict(zip(six.names, zip(six.low, six.high, strict=True), strict=True))
    torque, whole = spans["T0"], spans["B"]
    speed = torque[1] / whole[1]
    inertia, period = start["J"], min(record.timeline.period_s for record in records)
    slow = 2 * np.pi * SLOWEST / (samples * period)
    fast = 2 * np.pi * FASTEST / period
    spans["T_lc"] = (whole[0] / speed, whole[1] / speed)
    spans["J1"] = spans["J2"] = (PARTS[0] * inertia, PARTS[1] * inertia)
    spans["Ks"] = (PARTS[0] * inertia * slow**2, inertia * fast**2 / 4)
    spans["b"] = (DAMPING[0] * inertia * slow, DAMPING[1] * inertia * fast)
    low, high = np.array([spans[name] for name in free]).T
    return Box(tuple(free), low, high, log=True)
