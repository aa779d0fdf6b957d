"""What drives the model of a motor: a voltage in each interval, and the bridge behind it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Wiring
from motorid.estimate.signals.source.pwm_bridge import stretch_of
from motorid.estimate.signals.source.thevenin_source import Source
from motorid.estimate.signals.time_grid import Part
from motorid.estimate.signals.voltage_sensing import Sense
from motorid.motor.reading import Stretch

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Excitation:
    """Voltage (count,) in V, stretches of one bridge state, and the first stretch of every part."""

    volts: Floats
    stretches: tuple[Stretch, ...]
    first: tuple[int, ...]


def excitation(
    wiring: Wiring,
    supply_v: float | None,
    clamp_v: float,
    heard: Sense,
    parts: Sequence[Part],
    sources: Sequence[Source | None],
    switched_late: Sequence[int],
) -> Excitation:
    """Every part by its source, or by the voltage as ``heard`` where it has none.

    ``switched_late``: the interval up to which the PWM of each part is a dead time late.
    """
    volts = heard.volts.copy()
    stretches: list[Stretch] = []
    first: list[int] = []
    begin = partial(stretch_of, wiring, supply_v, clamp_v)
    for part, source, late in zip(parts, sources, switched_late, strict=True):
        if source is not None:
            volts[part.slice] = source.volts
        ohms = heard.series_ohm + (source.ohms if source else 0.0)
        first.append(len(stretches))
        edge = max(min(late, part.stop), part.start)
        if edge > part.start:
            stretches.append(begin(part, part.start, ohms, volts[part.start : edge]))
        if edge < part.stop:
            stretches.append(begin(part, edge, ohms, volts[edge : part.stop], in_time=True))
    return Excitation(volts, tuple(stretches), tuple(first))
