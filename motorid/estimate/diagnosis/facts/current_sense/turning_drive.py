"""Program, motion and current of a board's capture, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, Capture
from motorid.estimate.signals.measurements import motion
from motorid.estimate.signals.source.smoothing import smoothed
from motorid.program import StepKind

Floats = NDArray[np.float64]

BLOCKS = 200  # of a run, over one of which a position becomes a speed
SHORTEST = 3  # samples of one
DRIVES = (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)


@dataclass(frozen=True)
class Turning:
    """``level`` is the program's, signed, in shares of its largest, and 0 where nothing drives;
    ``current`` in A, ``speed`` in shares of the largest; (n,) each.
    """

    level: Floats
    current: Floats
    speed: Floats


def of(capture: Capture) -> Turning | None:
    """None: no board's capture, or one without a current, a motion or a drive."""
    current, moving = capture.get(CURRENT), motion(capture)
    if capture.program is None or current is None or moving is None or current.unsigned:
        return None
    level, width = _levels(capture), max(len(capture) // BLOCKS, SHORTEST)
    speed, readings = moving.values, current.values
    if len(capture) < BLOCKS or not (np.isfinite(speed).all() and np.isfinite(readings).all()):
        return None
    if moving.name == POSITION:
        speed = smoothed(np.gradient(speed), width // 2)
    top = float(np.abs(speed).max())
    if not level.any() or not readings.any() or not top > 0.0:
        return None
    return Turning(level / np.abs(level).max(), readings, speed / top)


def _levels(capture: Capture) -> Floats:
    """The program's level at each sample (n,), 0 where it does not drive."""
    steps = () if capture.program is None else capture.program.steps
    out = np.zeros(len(capture))
    for phase in capture.phases:
        step = steps[phase.index] if 0 <= phase.index < len(steps) else None
        driven = step is not None and step.kind in DRIVES
        out[np.searchsorted(capture.ticks, phase.tick) :] = step.level if step and driven else 0.0
    return out
