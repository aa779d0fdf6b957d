"""A low-pass in a channel that is said to have none: of a circuit, or done to a log afterwards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.smoothing_around import (
    FARTHEST,
    KERNELS,
    SMOOTHING_AROUND,
    WHOLE,
)
from motorid.estimate.effects.reading.speed_filter import SPEED_FILTER
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.time_grid import IRREGULAR

Floats = NDArray[np.float64]

SAMPLES = (0.5, 2.0, 6.0, 20.0)  # time constants that are tried
LONGEST = 500.0  # samples
SHORTEST = 1e-3
FILTERS = {CURRENT: CURRENT_FILTER, SPEED: SPEED_FILTER}
HALF_WIDTHS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # readings that are tried


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """One for the current, one for a measured speed; of logs also every way to smooth either."""
    period = min(r.timeline.period_s for r in records)
    names = {m.block.name for r in records for m in r.measured}
    found = [_of(name, period) for name in FILTERS if name in names]
    if all(r.sensed.waveform is not None and r.timeline.jitter <= IRREGULAR for r in records):
        kinds = (
            (name, *kind) for name in FILTERS if name in names
            for kind in SMOOTHING_AROUND[name].items()
        )  # fmt: skip
        found += [_smoothed(*kind) for kind in kinds]
    return found


def _smoothed(name: str, how: str, quantity: InfluenceQuantity) -> Hypothesis:
    def words(size: Floats) -> Words:
        return Words(
            name,
            f"the {name} shows its edges before they come, as behind {how} "
            f"({2.0 * size[0] + 1.0:.2g} readings wide)",
            quantity.remedy,
        )

    return Hypothesis(
        f"{name}_smoothed", acting(quantity), tuple((w,) for w in HALF_WIDTHS), (1.0,), (0.0,),
        (float(FARTHEST),), words, quantity=quantity, afterwards=True,
        whole=KERNELS[how] in WHOLE,
    )  # fmt: skip


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
