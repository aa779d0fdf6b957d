"""A low-pass in a channel that is said to have none: of a circuit, or done to a log afterwards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.diagnosis.fault import Hypothesis, Words, acting
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.smoothing import SMOOTHED
from motorid.estimate.effects.reading.smoothing_kernels import Smoothing
from motorid.estimate.effects.reading.speed_filter import SPEED_FILTER
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.time_grid import IRREGULAR

Floats = NDArray[np.float64]

SAMPLES = (0.5, 2.0, 6.0, 20.0)  # time constants that are tried
LONGEST = 500.0  # samples
SHORTEST = 1e-3
FILTERS = {CURRENT: CURRENT_FILTER, SPEED: SPEED_FILTER}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """For the current and for a measured speed: a circuit, and every way to smooth digitally.

    What shows an edge before it comes is done to logs alone.
    """
    period = min(r.timeline.period_s for r in records)
    names = {m.block.name for r in records for m in r.measured}
    even = all(r.timeline.jitter <= IRREGULAR for r in records)
    logged = all(r.sensed.waveform is not None for r in records)
    found = [_of(name, period) for name in FILTERS if name in names]
    ways = (
        (name, *way) for name in FILTERS if name in names and even
        for way in SMOOTHED[name].items() if logged or way[0].behind
    )  # fmt: skip
    return found + [_smoothed(*way) for way in ways]


def _smoothed(name: str, way: Smoothing, quantity: InfluenceQuantity) -> Hypothesis:
    def words(size: Floats) -> Words:
        return Words(name, shown(name, way, float(size[0])), quantity.remedy)

    return Hypothesis(
        f"{name}_smoothed", acting(quantity), tuple((w,) for w in way.sizes), (1.0,), (0.0,),
        (float(way.most),), words, quantity=quantity, afterwards=True, whole=way.whole,
        stepwise=way.behind > 0.0,
    )  # fmt: skip


def shown(name: str, way: Smoothing, size: float) -> str:
    """What the readings of a channel smoothed so show, in words."""
    shows = "reads" if way.behind else "shows its edges before they come,"
    return f"the {name} {shows} as behind {way.how} ({way.wide(size)})"


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
