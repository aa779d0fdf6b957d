"""A supply that is read before a fuse, a wire or a switch, which carries the bridge's current."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SUPPLY
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting, highest
from motorid.estimate.effects.bridge.supply_path import SUPPLY_PATH
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

SOME, MOST = 0.01, 0.3  # of the supply, at the highest current


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """One, where every capture drives the motor by duty of a supply that it reads."""
    peak_a = highest(records, CURRENT)
    read = [r.sensed.commanded and r.capture.get(SUPPLY) is not None for r in records]
    if not peak_a > 0.0 or not all(read):
        return []
    ohms = max(float(np.abs(r.volts).max()) for r in records) / peak_a

    def words(size: Floats) -> Words:
        return Words(
            "supply",
            f"there are about {1e3 * float(size[0]):.2g} mohm between the point where the supply "
            "is read and the bridge, as of a fuse, a wire or a switch against reversed polarity",
            SUPPLY_PATH.remedy,
        )

    return [
        Hypothesis(
            "supply_read_upstream", acting(SUPPLY_PATH), ((SOME * ohms,),), (SOME * ohms,), (0.0,),
            (MOST * ohms,), words, quantity=SUPPLY_PATH,
        )
    ]  # fmt: skip
