"""A current that is shown through a capacitor: the input of a probe or an oscilloscope set to AC.

Such an input is a high-pass of first order. What it shows, y, of a current i obeys

    dy/dt = di/dt − r y,    y = i − r ∫ e^(−r(t−s)) i(s) ds

with the rate r, one over its time constant. A rate of which little passes in a record makes a
steady current fade by a small share: the torque that friction takes seems to fade as well.
"""

from __future__ import annotations

import numpy as np

from motorid.capture.model import CURRENT
from motorid.estimate.effects.action import Floats, Reading
from motorid.estimate.effects.influence_quantity import (
    InfluenceQuantity,
    Scope,
    Subject,
    Use,
    undeclared,
)

MOST = 500.0  # time constants in a record: e to that power is a number still
SHORTEST = 20.0  # grid periods of a time constant: a faster one blocks what the motor does as well

SMALL = 1e-3  # of a time constant that passes in a record: what fades is in proportion to the rate


def faded(series: Floats, passed: Floats | float) -> Floats:
    """(n,) behind the high-pass; ``passed`` (n,): time from the last reading on, in time constants.

    The integral is that of trapezia, good to 1/12 of a step's square. The capacitor held nothing at
    the first reading.
    """
    steps = np.broadcast_to(passed, series.shape)
    if not steps.any():
        return series
    age = np.cumsum(steps)
    grown = np.exp(age - age[-1]) * series
    held = np.concatenate([[0.0], np.cumsum(steps[1:] * (grown[1:] + grown[:-1]) / 2.0)])
    return np.asarray(series - held * np.exp(age[-1] - age))


def _steps_s(subject: Subject) -> Floats:
    """(n,) s from each reading of the current to the next; 0 before the first."""
    measured = subject.block(CURRENT)
    assert measured is not None
    at = measured.keep if measured.past is None else measured.keep + measured.past
    return np.asarray(np.diff(at, prepend=at[0]) * subject.timeline.period_s)


def record_s(subject: Subject) -> float:
    """Length of a record, s."""
    return float(subject.timeline.period_s * max(subject.timeline.count, 1))


def _scale(subject: Subject) -> float:
    return SMALL / record_s(subject)


def bounds(subject: Subject) -> tuple[float, float]:
    """Rates, 1/s."""
    timeline = subject.timeline
    return 0.0, min(MOST / record_s(subject), 1.0 / (SHORTEST * timeline.period_s))


CURRENT_COUPLING = InfluenceQuantity(
    name="current coupling",
    unit="1/s",
    scope=Scope.MOTOR,
    use=Use.TESTED,
    acts=(Reading(CURRENT, faded, _steps_s),),
    prior=undeclared,
    scale=_scale,
    remedy="set the input of the current's probe to DC, or take one that shows a steady current",
    bounds=bounds,
    step=1e-3,
)
