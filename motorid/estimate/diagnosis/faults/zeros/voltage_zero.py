"""A zero of the voltage that is not where its channel declares it: a shifted ground, an amplifier.

Every reading of the terminals' voltage is off by the same amount. A motor that turns both ways, or
rests, shows it: no symmetric friction draws a current at no voltage.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting
from motorid.estimate.effects.source.voltage_offset import VOLTAGE_OFFSET
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

TRIED, MOST = 0.01, 0.3  # of the highest voltage


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """An offset of a log's voltage, which its fit takes for what drives the motor."""
    if not records or any(r.sensed.waveform is None for r in records):
        return []
    peak = max(float(np.abs(record.volts).max()) for record in records)
    if not peak > 0.0:
        return []

    def words(size: Floats) -> Words:
        return Words(
            "terminal voltage",
            f"the voltage reads {size[0]:+.3g} V at no voltage, as of a shifted ground or the "
            "zero of an amplifier or a probe",
            VOLTAGE_OFFSET.remedy,
        )

    return [
        Hypothesis(
            "voltage_offset", acting(VOLTAGE_OFFSET), ((TRIED * peak,),), (TRIED * peak,),
            (-MOST * peak,), (MOST * peak,), words, quantity=VOLTAGE_OFFSET, afterwards=True,
        )
    ]  # fmt: skip
