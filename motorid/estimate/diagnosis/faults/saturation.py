"""A channel that stops below the end that its converter declares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, SPEED, Capture
from motorid.estimate.diagnosis.fault import (
    Hypothesis,
    Words,
    changed_voltage,
    highest,
    showing,
)
from motorid.estimate.fit.block_regression import Start, blocks, electrical, mechanical
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

SHARES = (0.97, 0.9, 0.8, 0.65)  # of the highest reading, where the end is tried
TOP = 0.985  # of the highest voltage read: at its end
BELOW = 0.95  # of it: surely not
END = 0.97  # of where the readings stop: noise is cut off from there on
CLEAR = 0.02  # relative, by which the motor must answer to more than is read
UNITS = {CURRENT: "A", SPEED: "rad/s"}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """A current that stops, and a measured speed that does."""
    peaks = ((name, highest(records, name)) for name in UNITS)
    return [_of(name, peak) for name, peak in peaks if peak > 0.0]


def _of(name: str, peak: float) -> Hypothesis:
    def words(size: Floats) -> Words:
        return Words(
            name,
            f"the {name}'s readings stop at {size[0]:.3g} {UNITS[name]}, below the end of its "
            "converter",
            "use a sensor with more range, or drive with less voltage",
        )

    sizes = tuple((s * peak,) for s in SHARES)
    return Hypothesis(
        f"{name}_saturated", showing(name, _ending), sizes, (0.01 * peak,), (0.05 * peak,),
        (1.2 * peak,), words, remedy=partial(_declared_end, name),
    )  # fmt: skip


def _ending(y: Floats, size: Floats, _: float) -> Floats:
    return np.clip(y, -size[0], size[0])


def _declared_end(name: str, capture: Capture, end: float) -> list[Capture]:
    """The capture whose channel is declared to end there: readings at the end tell nothing."""
    channel = capture.channels[name]
    reach = END * end / abs(channel.scale)
    low, high = channel.offset - reach, channel.offset + reach
    ended = replace(channel, raw_min=max(channel.raw_min, low), raw_max=min(channel.raw_max, high))
    return [replace(capture, channels={**capture.channels, name: ended})]


def seen(records: Sequence[MotorRecord]) -> tuple[Hypothesis, Start] | None:
    """A voltage that stops: at its highest readings the motor answers to more than they say."""
    if not all(r.sensed.channel is not None and r.sensed.shows_emf for r in records):
        return None
    b = blocks(records)
    if b is None:
        return None
    peak = float(np.abs(b.volts[b.settled]).max(initial=0.0))
    top, below = np.abs(b.volts) > TOP * peak, np.abs(b.volts) < BELOW * peak
    motor = electrical(b, b.settled & below)
    if motor is None:
        return None
    R, K = motor
    use = b.settled & top
    answer = float(np.median((R * b.current + K * b.speed)[use] / b.volts[use]))
    if answer < 1.0 + CLEAR:
        return None
    begin = Start((answer,), {"R": R, "K": K, **mechanical(b, K, b.settled | ~b.driven)})
    return _voltage(peak), begin


def _voltage(peak: float) -> Hypothesis:
    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        """Where the source is at its end it gives ``size`` times as much."""
        usual = record.volts
        top = np.abs(usual) > TOP * peak
        return changed_voltage(record, values, own, np.where(top, size[0] * usual, usual))

    def words(size: Floats) -> Words:
        return Words(
            "terminal voltage",
            f"the voltage's readings stop at {peak:.3g} V, where the motor answers as to "
            f"{peak * size[0]:.3g} V",
            "use a divider with more range, or drive with less voltage",
        )

    return Hypothesis(
        "voltage_saturated", effect, ((1.0 + CLEAR,),), (0.05,), (1.0,), (3.0,), words
    )
