"""The delay of a log's voltage behind its stamps, which are often off by a sample.

Of means whose delay is stated, that is known.
"""

from __future__ import annotations

from motorid.estimate.effects.action import LogTime
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)


def _scale(subject: Subject) -> float:
    waveform = subject.sensed.waveform
    return waveform.period_s if waveform is not None else 1.0


def _prior(subject: Subject, _: int) -> Prior | None:
    waveform, channel = subject.sensed.waveform, subject.sensed.channel
    if waveform is None:
        return None
    stated = channel.delay_uncertainty_s if channel is not None else 0.0
    if waveform.window_s and channel is not None and channel.states("delay"):
        return Prior(stated) if stated else None
    return Prior(max(waveform.period_s, stated))


VOLTAGE_LATE = InfluenceQuantity(
    name="voltage late",
    unit="s",
    scope=Scope.CAPTURE,
    use=Use.ESTIMATED,
    acts=(LogTime(),),
    prior=_prior,
    scale=_scale,
    remedy="stamp all channels by one clock, or declare their delays (--delay)",
)
