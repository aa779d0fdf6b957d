"""A motor beside a resistor across its terminals, behind the current's sensor: another motor.

With R_p across it, by Thévenin and g = R_p/(R + R_p), all readings are those of a motor of

    R' = g R    K' = g K    B' = B + K²/(R + R_p)    J' = J    T0' = T0

at every voltage, while the bridge is open and while it shorts the motor. L' = g L keeps L/R, but
the sensor shows v/R_p at once: the integral of a step's current is that of L' = g² L, which a fit
finds.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def loaded(motor: Floats, names: Sequence[str], siemens: float) -> Floats:
    """The parameters (SI) by ``names`` as readings show them beside such a conductance.

    The same array where there is none. A conductance below 0 is what a derivative may try.
    """
    if not siemens:
        return motor
    out = motor.copy()
    r, inductance, k, b = (names.index(name) for name in ("R", "L", "K", "B"))
    share = 1.0 / (1.0 + siemens * motor[r])
    out[b] += siemens * share * motor[k] ** 2
    out[r] *= share
    out[inductance] *= share**2
    out[k] *= share
    return out
