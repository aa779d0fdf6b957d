"""A current that was measured in the bridge's supply, not in the motor.

PWM of duty d turns the motor's current i into d i at the supply. The motor's voltage is d times the
supply's, so that the supply's current over the motor's voltage is the motor's current but for a
factor. Where that follows a motor's laws and the logged current does not, the supply's was logged.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts.motor_laws import columns, convinces, left
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic

LOW = 0.08  # of the highest voltage: below it, the division makes noise of the current


def findings(capture: Capture, where: str = "") -> Iterator[Diagnostic]:
    """A log of the supply's current. ``where``: " in run 2", or nothing."""
    if not found(capture):
        return
    yield Diagnostic(
        "supply_current", "error",
        f"the current is the bridge's supply's, not the motor's{where}: the readings follow a "
        "motor's laws only if each is divided by the duty. Measure in the motor's lead, or import "
        "the current divided by the duty",
        dict.fromkeys(PARAMETERS, math.inf),
    )  # fmt: skip


def found(capture: Capture) -> bool:
    """Whether a log's current follows a motor's laws only after a division by the duty."""
    logged = columns(capture)
    if logged is None:
        return False
    volts, current, speed = logged
    driven = np.abs(volts) > LOW
    motors = np.where(driven, current / np.where(driven, volts, 1.0), 0.0)
    divided = left(volts, motors, speed, driven)
    return convinces(divided, left(volts, current, speed, driven))
