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
PERIODS = 4.0  # of a segment: fewer are a course, and no tone
SPREAD = 3.0  # frequencies of the segment's spectrum over which its window spreads a tone
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
    return f"{said}, {_frequencies(residual[inside], _between(m) * record.timeline.period_s)}"


def _between(m: Measured) -> float:
    """Ticks from one reading to the next."""
    return float(np.median(np.diff(m.keep)))


def _frequencies(residual: Floats, period_s: float) -> str:
    """In words; a tone is said to be one."""
    low, high = band(residual, period_s)
    in_all_s = period_s * len(residual)
    if (high - low) * in_all_s < SPREAD and low * in_all_s > PERIODS:
        hz = 0.5 * (low + high)
        return f"at {hz:.2g} Hz, a tone as of the mains, or of PWM that the sampling shows there"
    a, b = f"{low:.2g}", f"{high:.2g}"
    return f"at {a} Hz" if a == b else f"{a} to {b} Hz"


def band(residual: Floats, period_s: float) -> tuple[float, float]:
    """Hz, between which the middle of the power above a flat floor lies."""
    power = np.abs(np.fft.rfft(residual * np.hanning(len(residual)))) ** 2
    power = np.maximum(power - np.median(power), 0.0)
    total = np.cumsum(power) / max(float(power.sum()), 1e-300)
    frequency = np.fft.rfftfreq(len(residual), period_s)
    low, high = (int(np.searchsorted(total, share)) for share in MIDDLE)
    top = len(frequency) - 1
    return float(frequency[min(max(low, 1), top)]), float(frequency[min(max(high, 1), top)])
