"""The delay of the current readings beyond the declared one.

Where a reading lies in the PWM period decides how much of the ripple it shows, so that an instant
amid ripple tells its delay far better than any data sheet: the fit then estimates it. A mean over
whole periods shows its delay only by how a step begins, where the voltage is least sure.
"""

from __future__ import annotations

from motorid.capture.model import CURRENT
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Delay
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Scope, Subject, Use
from motorid.estimate.signals.source.discontinuous_current import shows_ripple

FARTHEST = 4.0  # standard uncertainties: beyond it the declaration is wrong
ROOM = 3.0  # standard uncertainties from no delay at all: no reading comes early


def _bounds(subject: Subject) -> tuple[float, float]:
    measured = subject.block(CURRENT)
    if measured is None:
        return 0.0, 0.0
    reach = FARTHEST * measured.channel.delay_uncertainty_s
    return max(-reach, scales.least_delay_s(measured)), reach


def _told(subject: Subject) -> bool:
    """It is uncertain, may be off either way, and places the readings in the ripple."""
    measured = subject.block(CURRENT)
    if measured is None:
        return False
    channel = measured.channel
    roomy = 0.0 < ROOM * channel.delay_uncertainty_s <= channel.delay_s
    pwm_hz = subject.capture.wiring.pwm_hz
    return roomy and shows_ripple(channel, subject.timeline.period_s, pwm_hz)


CURRENT_DELAY = InfluenceQuantity(
    name="current delay",
    unit="s",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Delay(CURRENT),),
    prior=scales.declared(CURRENT, "delay_uncertainty_s"),
    scale=scales.period_s,
    remedy="measure the delay of the current's channel",
    bounds=_bounds,
    step=2e-4,
    told=_told,
)
