"""A record of given readings, of which starts and blocks read the grid and the channels alone."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET

PERIOD_S = 1e-3
STEP, GEAR = 1e-4, 3.0  # of a reading in the channel's unit; the motor turns so much faster


def record(count: int, unsigned: bool = False, parts: tuple[int, ...] = (0,), **series: Any) -> Any:
    """``series`` of (kept samples, values) by channel; its voltage rises by .1 V a sample."""
    measured = [
        SimpleNamespace(
            block=SimpleNamespace(name=name), unsigned=unsigned, keep=keep, values=values,
            resolution=STEP if name == CURRENT else GEAR * STEP,
        )
        for name, (keep, values) in series.items()
    ]  # fmt: skip
    return SimpleNamespace(
        measured=measured, gear=GEAR, driven=np.ones(count, dtype=bool),
        unknowns=(SimpleNamespace(name=CURRENT_OFFSET.name, start=0.2),),
        timeline=SimpleNamespace(
            count=count, period_s=PERIOD_S,
            parts=tuple(SimpleNamespace(start=at, open=at == 100) for at in parts),
        ),
        sensed=SimpleNamespace(
            volts=2.0 + 0.1 * np.arange(count), series_ohm=0.5, waveform=None
        ),
        capture=SimpleNamespace(path="run.h5", get=lambda name: series.get(name)),
    )  # fmt: skip
