"""A first-order low-pass in a channel that is said to have none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.diagnosis.fault import Hypothesis, Words, nothing, series
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

SAMPLES = (0.5, 2.0, 6.0, 20.0)  # time constants that are tried
LONGEST = 500.0  # samples
SHORTEST = 1e-3


def filtered(values: Floats, samples: float) -> Floats:
    """(count,) behind a low-pass of ``samples`` sample periods, joined by straight lines.

    The first value has lasted for ever.
    """
    h = 1.0 / samples
    a = float(np.exp(-h))
    late, now = (1.0 - a) / h - a, 1.0 - (1.0 - a) / h
    size = 1 << (2 * len(values) - 1).bit_length()
    back = np.exp(-2j * np.pi * np.arange(size // 2 + 1) / size)
    gain = (now + late * back) / (1.0 - a * back)
    moved = np.fft.irfft(np.fft.rfft(values - values[0], size) * gain, size)
    return np.asarray(moved[: len(values)] + values[0])


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """One for the current, one for a measured speed."""
    period = min(r.timeline.period_s for r in records)
    names = {m.block.name for r in records for m in r.measured}
    return [_of(name, period) for name in (CURRENT, SPEED) if name in names]


def _of(name: str, period: float) -> Hypothesis:
    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        out = nothing(record)
        for k, y in series(record, values, own, name):
            samples = max(float(size[0]) / record.timeline.period_s, SHORTEST)
            out[k] = (filtered(y, samples) - y)[record.measured[k].where]
        return out

    def words(size: Floats) -> Words:
        return Words(
            name,
            f"the {name} reads as behind a low-pass of {1e6 * size[0]:.0f} µs "
            f"({1 / (2 * np.pi * size[0]):.3g} Hz)",
            f"take the filter out of the {name} channel, or correct the readings for it",
        )

    return Hypothesis(
        f"{name}_filtered", effect, tuple((k * period,) for k in SAMPLES), (period,),
        (SHORTEST * period,), (LONGEST * period,), words,
    )  # fmt: skip
