"""A board's current that was read in the bridge's supply or foot: the motor's times the duty.

While a bridge drives with the duty d, its supply carries the motor's current i in the on part
alone, d i in the mean, with the sign of the power. Divided by the duty, such readings follow a
motor's laws; as they are, they do not. Where the bridge brakes or is open they show nothing of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.facts.current_sense import turning_drive
from motorid.estimate.diagnosis.facts.current_sense.turning_drive import BLOCKS, Turning
from motorid.estimate.diagnosis.facts.motor_laws import Shares, convinces, left
from motorid.estimate.results.estimate import Suspect

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

FEW = 0.08  # of the largest level: below it, a division makes noise of the current


def suspects(capture: Capture) -> Sequence[Suspect]:
    """What the readings show of it."""
    turning = turning_drive.of(capture)
    if turning is None or not found(turning):
        return ()
    return (
        Suspect(
            "supply_current", "current",
            "the current is that of the bridge's supply, or of a resistor in its foot: while the "
            "bridge drives, the readings follow a motor's laws only if each is divided by the duty",
            "read the current in the motor's lead", "named",
        ),
    )  # fmt: skip


def found(turning: Turning) -> bool:
    """Whether the current follows a motor's laws only after a division by the duty."""
    driven = np.abs(turning.level) > FEW
    if len(np.unique(np.abs(turning.level[driven]))) < 2:
        return False
    taken = turning.current / np.abs(turning.current).max()
    duty = np.where(driven, np.abs(turning.level), 1.0)
    signs = np.where(driven, np.sign(turning.level), 1.0)
    signed, magnitude = (
        (_left(turning, i / duty, driven), _left(turning, i, driven))
        for i in (taken * signs, np.abs(taken) * signs)
    )  # fmt: skip
    stated, as_read = _left(turning, taken, driven), _left(turning, taken / duty, driven)
    candidates = [as_read, signed[0], magnitude[0]]
    best = min(candidates, key=sum)
    return all(convinces(best, other) for other in (stated, signed[1], magnitude[1]))


def _left(turning: Turning, current: Floats, driven: Bools) -> Shares:
    return left(turning.level, current, turning.speed, driven, BLOCKS)
