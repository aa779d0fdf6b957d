"""A mean of few conversions evenly spread over the PWM period is not quite the mean of the voltage.

Behind a filter of first order the voltage bends at both edges of a pulse. Between conversions that
lie d apart, each bend of V/t moves the mean over a period T by

    d²/(2 T) · V/t · (x² - x + 1/6)

x is where in the spacing the edge falls. No reading shows it, and each duty has its own. At full
duty there are no edges. So levels below the highest err, which looks like a drop of the brushes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from motorid.capture.model import Channel
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import PartVoltage
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.program import StepKind

DRIVEN = (StepKind.DRIVE_DUTY, StepKind.DRIVE_VOLTS)
BENDS = (2.0 / 180.0) ** 0.5  # standard, of two edges anywhere between conversions
FULL = 0.99  # of the highest voltage: a level without edges


def deviation(channel: Channel, swing_v: float, period_s: float) -> float:
    """Standard uncertainty (V) of a mean over PWM periods of ``swing_v``; 0: not sampled so."""
    if channel.kind != "mean" or channel.pwm_phase is None or channel.filter_order != 1:
        return 0.0
    if not channel.filter_s or not period_s:
        return 0.0
    spacing_s = channel.pwm_phase * period_s
    return BENDS * spacing_s**2 / (2.0 * period_s) * swing_v / channel.filter_s


def _parts(subject: Subject) -> Sequence[int]:
    """With edges: driven, below full duty."""
    full = FULL * scales.top_volts(subject)
    return [
        place
        for place, part in enumerate(subject.timeline.parts)
        if part.kind in DRIVEN and abs(float(np.median(subject.volts[part.slice]))) < full
    ]


def _prior(subject: Subject, place: int) -> Prior | None:
    channel = subject.sensed.channel
    if channel is None or subject.sensed.commanded:
        return None
    found = deviation(channel, scales.top_volts(subject), subject.pwm_period_s)
    return Prior(found) if found else None


SAMPLING_PHASES = InfluenceQuantity(
    name="sampling phases",
    unit="V",
    scope=Scope.PART,
    use=Use.PROPAGATED,
    acts=(PartVoltage(),),
    prior=_prior,
    scale=scales.volts,
    remedy="filter the voltage with a longer time constant, or take a board of more conversions",
    places=_parts,
    listed=False,
)
