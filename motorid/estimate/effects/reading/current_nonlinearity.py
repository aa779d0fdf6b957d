"""The non-linearity of the current's sensor: its reading leaves the straight line of its gain.

    shown = i + size F p(i/F)

F is the full scale. The largest departure within it is one size. Its course is the sensor's:

    bow    p = 2 x²        about the best straight line, the same at either sign
    s      p = 4 x³ - 3 x  about the best straight line, turned at the other sign
    cubic  p = x³          about the line that is right at small currents

The first two are Chebyshev's, whose departures are alike at all their ends. The zero of a bow is
taken at no current. An S turns the line at small currents by three sizes, which leaves no residual.
A fit could see how it bends within the motor's currents and conclude on that slope; but cogging and
dead time bend a current as much, and the slope is many times what they leave. So it is propagated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from motorid.capture.model import CURRENT, Curve
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Added, Floats
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Prior,
    Scope,
    Subject,
    Use,
)

COURSES: Mapping[Curve, Callable[[Floats], Floats]] = {
    "bow": lambda x: 2.0 * x**2,
    "s": lambda x: 4.0 * x**3 - 3.0 * x,
    "cubic": lambda x: x**3,
}


def _course(subject: Subject, _: int, amperes: Floats) -> Floats:
    """A (n,), for a departure of one full scale."""
    measured = subject.block(CURRENT)
    assert measured is not None
    shape, full = measured.channel.nonlinearity_shape, measured.channel.full_scale
    assert shape is not None
    return full * COURSES[shape](amperes / full)


def _prior(subject: Subject, _: int) -> Prior | None:
    """As its channel declares, shape and full scale with it."""
    measured = subject.block(CURRENT)
    channel = measured.channel if measured is not None else None
    if channel is None or channel.nonlinearity_shape is None or not channel.full_scale:
        return None
    return Prior(channel.nonlinearity) if channel.nonlinearity else None


CURRENT_NONLINEARITY = InfluenceQuantity(
    name="current non-linearity",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.PROPAGATED,
    acts=(Added(CURRENT, _course),),
    prior=_prior,
    scale=scales.one,
    remedy="calibrate the current at the levels of the program, or take a more linear sensor",
)
