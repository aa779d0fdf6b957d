"""A current's reading that follows the voltage of the motor, with the bridge open as well."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting, highest
from motorid.estimate.effects.reading.current_common_mode import CURRENT_COMMON_MODE
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

SOME = 0.01  # of the highest current, at the highest voltage: what is tried


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """Of boards that read the motor's voltage while the bridge is open as well."""
    if any(not r.sensed.shows_emf or r.capture.get(VOLTAGE) is None for r in records):
        return []
    peak = highest(records, CURRENT)
    volts = max(float(np.abs(record.volts).max()) for record in records)
    if not peak > 0.0 or not volts > 0.0:
        return []

    def words(size: Floats) -> Words:
        return Words(
            "current",
            f"the current reads {float(size[0]):+.2g} A for each volt at the motor, with the "
            "bridge open as well, as of an amplifier in a lead that follows its common mode",
            CURRENT_COMMON_MODE.remedy,
        )

    most = peak / volts
    return [
        Hypothesis(
            "current_common_mode", acting(CURRENT_COMMON_MODE), ((SOME * most,),), (SOME * most,),
            (-most,), (most,), words, quantity=CURRENT_COMMON_MODE,
        )
    ]  # fmt: skip
