"""The share of its counts that an encoder's counter misses above some rate.

Edges come closer than a filter or an interrupt can follow: those first that an error of the two
tracks' duty or phase moved together. Of the rotation dθ the counter shows

    dθ (1 - s p(|ω|/w)),    p(x) = 1 / (1 + exp((1 - x)/TRANSITION))

so that a position falls ever farther behind, and a speed reads low. No speed below w is touched:
K of the back-EMF seems to be larger at high ones. A counter misses counts and adds none: s ≥ 0.
The rate w is the place of the quantity, w = exp(place/STEPS) rad/s.
"""

from __future__ import annotations

import math

import numpy as np

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import Added, Floats
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)

TRANSITION = 0.01  # of the rate: within which a counter begins to miss
STEPS = 100  # of the rate, in a factor of e
MOST = 0.5  # of the counts: edges of one track
STEEP = 50.0  # of an exponent: beyond it nothing is missed


def place_of(above: float) -> int:
    """The place of a rate (rad/s)."""
    return round(STEPS * math.log(above))


def rate_of(place: int) -> float:
    """The rate (rad/s) of a place."""
    return math.exp(place / STEPS)


def missed_share(rate: Floats, above: float) -> Floats:
    """(n,) of a counter that misses everything at rates (n,) above ``above``, all in rad/s."""
    beyond = np.clip((1.0 - np.abs(rate) / above) / TRANSITION, -STEEP, STEEP)
    return np.asarray(1.0 / (1.0 + np.exp(beyond)))


def behind(position: Floats, elapsed_s: Floats | float, above: float) -> Floats:
    """rad (n,) by which a position (n,) would fall behind, if all counts above a rate were missed;
    ``elapsed_s`` since the reading before, (n,) or one figure.
    """
    moved = np.diff(position, prepend=position[0])
    return np.asarray(np.cumsum(moved * missed_share(moved / elapsed_s, above)))


def _of_position(subject: Subject, place: int, position: Floats) -> Floats:
    measured = subject.block(POSITION)
    assert measured is not None
    ticks = np.diff(measured.keep, prepend=measured.keep[0] - 1)
    return -behind(position, ticks * subject.timeline.period_s, rate_of(place))


def _of_speed(_: Subject, place: int, speed: Floats) -> Floats:
    return -speed * missed_share(speed, rate_of(place))


MISSED_COUNTS = InfluenceQuantity(
    name="missed counts",
    unit="1",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(Added(POSITION, _of_position), Added(SPEED, _of_speed)),
    prior=undeclared,
    scale=scales.one,
    remedy="count with a faster counter or a shorter filter, take fewer lines, or run slower",
)
