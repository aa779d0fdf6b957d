"""The low-pass filter of first order before the current's converter.

It is declared with the board; its resistor and capacitor are known to their tolerance. Taken for a
pure delay it makes L too large, since a rise that is rounded looks like a slower one.
"""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects.action import LowPass
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

TOLERANCE = 0.1 / 3.0**0.5  # relative standard uncertainty: parts of 10 %, evenly
FARTHEST = 4.0  # standard uncertainties: beyond it the declaration is wrong


def _declared_s(subject: Subject) -> float:
    """Time constant of the filter as the fit models it, s."""
    measured = subject.block(CURRENT)
    return min(measured.channel.filter_s, measured.channel.delay_s) if measured else 0.0


def _prior(subject: Subject, _: int) -> Prior | None:
    declared = _declared_s(subject)
    return Prior(TOLERANCE * declared) if declared else None


def _bounds(subject: Subject) -> tuple[float, float]:
    reach = FARTHEST * TOLERANCE * _declared_s(subject)
    return -reach, reach


CURRENT_FILTER = InfluenceQuantity(
    name="current filter",
    unit="s",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(LowPass(CURRENT),),
    prior=_prior,
    scale=_declared_s,
    remedy="measure the time constant of the filter before the current's converter",
    bounds=_bounds,
    step=1e-3,
    told=lambda subject: _declared_s(subject) > 0.0,
)
