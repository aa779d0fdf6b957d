"""A share of the motor's voltage in the reading of its current: what an amplifier does not reject.

    shown = i + size v

An amplifier in a lead of the motor follows the voltage of that lead (its common mode) as well as
what falls on its shunt. Where the bridge is open no current flows, and it shows the back-EMF.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT, VOLTAGE
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Added, Floats
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)


def _of_voltage(subject: Subject, _: int, amperes: Floats) -> Floats:
    """V (n,), as it was read with each current; 0 where it was not."""
    channel, measured = subject.capture.get(VOLTAGE), subject.block(CURRENT)
    if channel is None or measured is None:
        return np.zeros(len(amperes))
    return np.nan_to_num(subject.timeline.spread(channel.values)[measured.keep])


def _scale(subject: Subject) -> float:
    return scales.extent(CURRENT)(subject) / scales.volts(subject)


CURRENT_COMMON_MODE = InfluenceQuantity(
    name="common mode of the current",
    unit="S",
    scope=Scope.CAPTURE,
    use=Use.TESTED,
    acts=(Added(CURRENT, _of_voltage),),
    prior=undeclared,
    scale=_scale,
    remedy="take an amplifier that rejects the common mode better, or a shunt at ground",
)
