"""Where a channel misfits: the segment and the band of frequencies that hold most of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.diagnosis.misfit import noise_variance
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.signals.measurements import Measured
from motorid.segment import Segment

Floats = NDArray[np.float64]

FEWEST = 16  # readings of a segment that has a spectrum
MIDDLE = (0.1, 0.9)  # of the power, between whose frequencies a band lies


def place(record: MotorRecord, m: Measured, residual: Floats, segments: Sequence[Segment]) -> str:
    """As "62 % of it in the acceleration segment from 0.05 to 0.11 s, 3 to 40 Hz"; or "".

    ``residual`` (n,) are the block's, as the likelihood counts them.
    """
    above = residual**2 - noise_variance(m, residual)
    total = float(above.sum())
    best: tuple[float, Segment, slice] | None = None
    for s in segments:
        if s.stop - s.start < 1:
            continue
        first, last = record.timeline.index[s.start], record.timeline.index[s.stop - 1]
        inside = slice(*np.searchsorted(m.keep, [first, last + 1]).tolist())
        held = float(above[inside].sum())
        if best is None or held > best[0]:
            best = held, s, inside
    if best is None or not total > 0 or not best[0] > 0:
        return ""
    held, s, inside = best
    time = record.capture.time_s
    said = (
        f"{min(held / total, 1.0):.0%} of it in the {s.kind.value} segment from "
        f"{time[s.start]:.3g} to {time[s.stop - 1]:.3g} s"
    )
    if inside.stop - inside.start < FEWEST:
        return said
    low, high = (f"{f:.2g}" for f in band(residual[inside], record.timeline.period_s))
    return f"{said}, {f'at {low}' if low == high else f'{low} to {high}'} Hz"


def band(residual: Floats, period_s: float) -> tuple[float, float]:
    """Hz, between which the middle of the power above a flat floor lies."""
    power = np.abs(np.fft.rfft(residual * np.hanning(len(residual)))) ** 2
    power = np.maximum(power - np.median(power), 0.0)
    total = np.cumsum(power) / max(float(power.sum()), 1e-300)
    frequency = np.fft.rfftfreq(len(residual), period_s)
    low, high = (int(np.searchsorted(total, share)) for share in MIDDLE)
    top = len(frequency) - 1
    return float(frequency[min(max(low, 1), top)]), float(frequency[min(max(high, 1), top)])
