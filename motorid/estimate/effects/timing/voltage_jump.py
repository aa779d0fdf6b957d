"""The moment of each jump of a log's voltage, between the two stamps about it."""

from __future__ import annotations

from collections.abc import Sequence

from motorid.estimate.effects import scales
from motorid.estimate.effects.action import LogJump
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

EVEN = 12.0**-0.5  # standard deviation of what lies anywhere from 0 to 1


def _jumps(subject: Subject) -> Sequence[int]:
    waveform = subject.sensed.waveform
    return range(len(waveform.jumps)) if waveform is not None else ()


VOLTAGE_JUMP = InfluenceQuantity(
    name="voltage jump",
    unit="1",
    scope=Scope.PART,
    use=Use.ESTIMATED,
    acts=(LogJump(),),
    prior=lambda subject, place: Prior(EVEN, mean=0.5),
    scale=scales.one,
    step=1e-7,  # of the sample: far below the ramp of a jump
    remedy="log the voltage faster, or the moments of its steps",
    bounds=lambda subject: (0.0, 1.0),
    places=_jumps,
    listed=False,
)
