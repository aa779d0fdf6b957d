"""The reading of the current's channel at no current."""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Reading, plus
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)
from motorid.estimate.effects.unstated import default

UNSTATED = 0.01  # of the current's extent: standard, of a log whose zero nobody states
QUIET = 10  # readings with the bridge open that tell it


def _prior(subject: Subject, _: int) -> Prior | None:
    """As its channel declares; by the readings alone where enough of them are at rest."""
    measured = subject.block(CURRENT)
    if measured is None or measured.unsigned:
        return None
    at_rest = measured.values[~subject.driven[measured.keep]]
    sd = measured.channel.offset_uncertainty or np.inf
    if default.unstated(subject, measured.channel, "offset"):
        sd = UNSTATED * scales.extent(CURRENT)(subject)
    if len(at_rest) < QUIET:
        return Prior(sd) if np.isfinite(sd) else None
    return Prior(sd, start=float(np.median(at_rest)))


CURRENT_OFFSET = InfluenceQuantity(
    name="current offset",
    unit="A",
    scope=Scope.MOTOR,
    use=Use.ESTIMATED,
    acts=(Reading(CURRENT, plus),),
    prior=_prior,
    scale=scales.extent(CURRENT),
    remedy="record the current with the bridge open before and after the run",
)
