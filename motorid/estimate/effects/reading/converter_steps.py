"""The jumps of the readings at a converter's wide codes, which are of no exact width (RP2040-E11).

    shown = x + size u p(x)

u is what the channel declares. p counts the wide codes between the middle of the range and x: they
stand at 1/8, 3/8, 5/8 and 7/8 of it. The slope that goes with them is in the gain's uncertainty.
The channels share the converter, so that one size moves current and voltage. At levels beyond a
wide code the jump looks like a drop of the brushes, and no residual tells them apart: it is
propagated.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT, Channel
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Added, Floats, SourceVoltage
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.signals.measurements import EMF

PLACES = (1 / 4, 3 / 4)  # of half the range, on both sides of its middle
WIDE = 1 / 230  # of half the range: a wide code, within which readings do not move


def steps(channel: Channel, values: Floats) -> Floats:
    """What the channel shows more (n,) at values (n,) of its quantity, for a size of one."""
    if not is_stepped(channel):
        return np.zeros_like(values)
    middle = (channel.raw_min + channel.raw_max) / 2.0
    half = abs(channel.scale) * (channel.raw_max - channel.raw_min) / 2.0
    place = (values - channel.scale * (middle - channel.offset)) / half
    passed = sum(np.clip((np.abs(place) - one) / WIDE + 0.5, 0.0, 1.0) for one in PLACES)
    return np.asarray(channel.step_uncertainty * np.sign(place) * passed)


def is_stepped(channel: Channel | None) -> bool:
    """Whether it declares such jumps, and the range in which they are."""
    if channel is None or not channel.step_uncertainty:
        return False
    return bool(np.isfinite([channel.raw_min, channel.raw_max]).all())


def _shown(block: str) -> Added:
    def course(subject: Subject, _: int, series: Floats) -> Floats:
        measured = subject.block(block)
        assert measured is not None
        return steps(measured.channel, series)

    return Added(block, course)


def _lost_volts(subject: Subject, _: int) -> Floats | float:
    """V (count,): what reads too much had less behind it."""
    channel = subject.sensed.channel
    return 0.0 if channel is None else -steps(channel, subject.volts)


def _prior(subject: Subject, _: int) -> Prior | None:
    current = subject.block(CURRENT)
    known = (subject.sensed.channel, current.channel if current is not None else None)
    return Prior(1.0) if any(map(is_stepped, known)) else None


CONVERTER_STEPS = InfluenceQuantity(
    name="converter steps",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(SourceVoltage(_lost_volts), _shown(CURRENT), _shown(EMF)),
    prior=_prior,
    scale=scales.one,
    remedy="take a board whose converter has no wide codes, or smaller dividers",
)
