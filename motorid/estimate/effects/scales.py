"""Typical sizes in a capture, over which the effect of a quantity keeps its course."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import POSITION, SPEED
from motorid.estimate.effects.influence_quantity import Prior, Subject
from motorid.estimate.signals.measurements import Measured, after_filter_s

Floats = NDArray[np.float64]
LEAST_FRICTION = 1e-3  # of the stall torque: friction that counts


def one(_: Subject) -> float:
    """Of a relative size."""
    return 1.0


def extent_of(values: Floats) -> float:
    """From the least to the most, or what a constant is."""
    return float(np.ptp(values)) or float(np.abs(values).max()) or 1.0


def extent(block: str) -> Callable[[Subject], float]:
    """That of a block's readings; 1 where there is none."""

    def of(subject: Subject) -> float:
        measured = subject.block(block)
        return 1.0 if measured is None else extent_of(measured.values)

    return of


def volts(subject: Subject) -> float:
    """V, that of the voltage."""
    return extent_of(subject.sensed.volts)


def period_s(subject: Subject) -> float:
    """s: of a reading's place amid PWM or samples."""
    return subject.pwm_period_s or subject.timeline.period_s


def moving(subject: Subject) -> Measured | None:
    """The block that shows the motion."""
    return subject.block(POSITION) or subject.block(SPEED)


def speed(subject: Subject) -> float:
    """Highest mean speed (rad/s) over a twentieth of the readings; 0: no motion was measured."""
    measured = moving(subject)
    if measured is None:
        return 0.0
    if measured.block.name == SPEED:
        return float(np.abs(measured.values).max())
    step = max(len(measured.values) // 20, 1)
    turned, ticks = np.diff(measured.values[::step]), np.diff(measured.keep[::step])
    return float(np.abs(turned / ticks).max(initial=0.0)) / subject.timeline.period_s


def declared(block: str, uncertainty: str) -> Callable[[Subject, int], Prior | None]:
    """By a standard uncertainty that a block's channel declares; none where it declares none."""

    def prior(subject: Subject, _: int) -> Prior | None:
        measured = subject.block(block)
        sd = float(getattr(measured.channel, uncertainty)) if measured is not None else 0.0
        return Prior(sd) if sd else None

    return prior


def least_delay_s(measured: Measured | None) -> float:
    """Of a change of a block's delay (s), not above 0: no reading shows what comes after it.

    A filter before the converter counts in the delay, but cannot be read ahead of.
    """
    return 0.0 if measured is None else -after_filter_s(measured.channel, measured.block.name)


def stall(subject: Subject) -> float:
    """A, at the highest voltage with the resistance that its source was judged by."""
    assert subject.judged_at is not None
    return _highest_v(subject) / float(subject.judged_at[0])


def top_speed(subject: Subject) -> float:
    """rad/s, that the highest voltage would give the motor that its source was judged by."""
    assert subject.judged_at is not None
    return _highest_v(subject) / float(subject.judged_at[2])


def friction(subject: Subject, dry: bool = True) -> float:
    """N·m at that speed, at least a part of the stall torque; not ``dry``: the viscous part."""
    assert subject.judged_at is not None
    _, _, K, B, _, T0 = (float(x) for x in subject.judged_at[:6])
    torque = (T0 if dry else 0.0) + B * top_speed(subject)
    return max(torque, LEAST_FRICTION * K * stall(subject))


def _highest_v(subject: Subject) -> float:
    return float(np.abs(subject.volts).max(initial=0.0)) or 1.0


def top_volts(subject: Subject) -> float:
    """V, the highest that drove the motor."""
    return subject.loss.top_v if subject.loss is not None else volts(subject)
