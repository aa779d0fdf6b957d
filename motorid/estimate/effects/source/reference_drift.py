"""The drift of the converters' reference in a run, by which all gains move alike.

    gain = 1 + size (1 - exp(-t/tau))

A reference that falls makes every converter read too much. A sensor that follows the reference
shows its current as before. Magnets that warm from run to run look the same, so that readings do
not determine it: it is propagated.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Floats, Reading, SourceVoltage, times
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.measurements import EMF


def _prior(subject: Subject, _: int) -> Prior | None:
    wiring = subject.capture.wiring
    if not wiring.reference_drift or not wiring.reference_time_s:
        return None
    return Prior(wiring.reference_drift)


def _course(subject: Subject, ticks: Floats) -> Floats:
    """Share (n,) of the drift that has set in at ticks (n,) of the grid."""
    time_s = ticks * subject.timeline.period_s
    return -np.expm1(-time_s / subject.capture.wiring.reference_time_s)


def _lost_volts(subject: Subject, _: int) -> Floats:
    """V (count,): what reads too much had less behind it."""
    ticks = np.arange(subject.timeline.count, dtype=np.float64)
    return -_course(subject, ticks) * subject.volts


def _of_current(subject: Subject) -> Floats | float:
    measured = subject.block(CURRENT)
    if measured is None or measured.channel.ratiometric:
        return 0.0
    return _course(subject, measured.keep.astype(np.float64))


def _of_emf(subject: Subject) -> Floats | float:
    measured = subject.block(EMF)
    return 0.0 if measured is None else _course(subject, measured.keep.astype(np.float64))


REFERENCE_DRIFT = InfluenceQuantity(
    name="reference drift",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(
        SourceVoltage(_lost_volts),
        Reading(CURRENT, times, _of_current),
        Reading(EMF, times, _of_emf),
    ),
    prior=_prior,
    scale=scales.one,
    remedy="let the board warm up before the run, or give its converter a steadier reference",
)
