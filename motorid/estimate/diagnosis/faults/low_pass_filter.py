"""A first-order low-pass in a channel that is said to have none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.speed_filter import SPEED_FILTER
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

SAMPLES = (0.5, 2.0, 6.0, 20.0)  # time constants that are tried
LONGEST = 500.0  # samples
SHORTEST = 1e-3
FILTERS = {CURRENT: CURRENT_FILTER, SPEED: SPEED_FILTER}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """One for the current, one for a measured speed."""
    period = min(r.timeline.period_s for r in records)
    names = {m.block.name for r in records for m in r.measured}
    return [_of(name, period) for name in FILTERS if name in names]


def _of(name: str, period: float) -> Hypothesis:
    def words(size: Floats) -> Words:
        return Words(
            name,
            f"the {name} reads as behind a low-pass of {1e6 * size[0]:.0f} µs "
            f"({1 / (2 * np.pi * size[0]):.3g} Hz)",
            f"take the filter out of the {name} channel, or correct the readings for it",
        )

    return Hypothesis(
        f"{name}_filtered", acting(FILTERS[name]), tuple((k * period,) for k in SAMPLES), (period,),
        (SHORTEST * period,), (LONGEST * period,), words, quantity=FILTERS[name],
    )  # fmt: skip
