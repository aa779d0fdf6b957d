"""An encoder, or its counter, that does not follow fast edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION
from motorid.estimate.diagnosis.fault import Hypothesis, Words, nothing, series
from motorid.estimate.fit.block_regression import Start, blocks, electrical, mechanical
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

TOP = 0.97  # of the highest speed: where edges may be lost
BELOW = 0.85  # of it: surely not
CLEAR = 0.02  # relative, by which the motor must be faster than its encoder says


def seen(records: Sequence[MotorRecord]) -> tuple[Hypothesis, Start] | None:
    """Edges lost above some speed: at the highest speeds the back-EMF is more than they say."""
    positions = [m for r in records for m in r.measured if m.block.name == POSITION]
    b = blocks(records)
    if b is None or not positions:
        return None
    peak = float(np.abs(b.speed[b.settled]).max(initial=0.0))
    motor = electrical(b, b.settled & (np.abs(b.speed) < BELOW * peak))
    use = b.settled & (np.abs(b.speed) > TOP * peak)
    if motor is None:
        return None
    R, K = motor
    if float(np.median((b.volts - R * b.current)[use] / (K * b.speed[use]))) < 1.0 + CLEAR:
        return None
    slow = np.abs(b.speed) < BELOW * peak
    begin = Start((TOP * peak,), {"R": R, "K": K, **mechanical(b, K, slow)})
    return _hypothesis(peak, positions[0].resolution), begin


def _hypothesis(peak: float, step: float) -> Hypothesis:
    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        out, most = nothing(record), float(size[0]) * record.timeline.period_s
        for k, y in series(record, values, own, POSITION):
            moved = np.diff(y, prepend=y[0])
            out[k] = np.cumsum(np.clip(moved, -most, most) - moved)[record.measured[k].where]
        return out

    def words(size: Floats) -> Words:
        rate = f", {size[0] / step:.3g} counts a second" if step else ""
        return Words(
            "position",
            f"the encoder loses counts above {size[0]:.4g} rad/s{rate}",
            "use a faster counter or fewer lines, or run slower",
        )

    return Hypothesis(
        "encoder_loses_counts", effect, ((peak,),), (0.01 * peak,), (0.5 * peak,), (1.5 * peak,),
        words,
    )  # fmt: skip
