"""The rotor's angle at every tick, and what an open bridge shows of a ripple along it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION
from motorid.estimate.model.angle_spectrum import MOST
from motorid.estimate.signals.measurements import Measured
from motorid.estimate.signals.source.smoothing import smoothed
from motorid.motor.reading import Output

if TYPE_CHECKING:
    from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

FINE = 0.02  # rad of an encoder's step that shows what repeats 60 times a turn
EXACT = 0.05  # rad of the shortest period that is looked for: what its rounding may err by


def measured_angle(record: MotorRecord, fitted: Sequence[Floats]) -> Floats | None:
    """(count,) rad from the first reading on, where an encoder is fine enough to show it.

    The model's angle (``fitted``: what it makes of each block) adds up what is wrong of a speed,
    many turns of it.
    """
    fine = [
        k
        for k, m in enumerate(record.measured)
        if m.block.name == POSITION and 0.0 < m.resolution < FINE
    ]
    if not fine:
        return None
    m, model = record.measured[fine[0]], fitted[fine[0]]
    rounded = m.resolution / math.sqrt(12.0) * MOST / EXACT
    about = int(rounded**2 / 2.0)  # readings on either side that its rounding is smoothed over
    left = m.values - model
    shown = model + (smoothed(left, about) if about else left)
    shown -= m.values[0]  # a fitted origin would turn every phase as it moves
    late = m.channel.delay_s / record.timeline.period_s
    return np.interp(np.arange(record.timeline.count), m.keep - late, shown)


def rippled(
    m: Measured, output: Output, volts: Floats, K: float, wave: tuple[float, float], angle: Floats,
    period_s: float,
) -> Floats:  # fmt: skip
    """What a ripple of 1 adds to readings (n,) of a back-EMF, whose ``volts`` (n,) are without it.

    ``wave``: periods a turn, and the phase (rad) at no angle; ``angle`` (count,) at every tick.
    """
    periods, phase = wave
    ticks = np.arange(len(angle))
    past = m.keep if m.past is None else m.keep + m.past
    at = past - output.delay_s / period_s
    turned = periods * np.interp(at, ticks, angle) + phase
    if output.aperture_s == 0.0:
        return np.asarray(volts * np.cos(turned))
    before = at - output.aperture_s / period_s
    swept = np.sin(turned) - np.sin(periods * np.interp(before, ticks, angle) + phase)
    return np.asarray(K * swept / (periods * output.aperture_s))
