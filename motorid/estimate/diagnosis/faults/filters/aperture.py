"""A current that is read at an instant where the board says a mean, or the other way round.

An instant shows the ripple of the PWM where it is taken, and half a window later. Behind a mean
over a period neither is there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture, Channel
from motorid.estimate.diagnosis.fault import Hypothesis, Words, nothing
from motorid.estimate.model.capture_model import MotorRecord

Floats = NDArray[np.float64]

CODE = "current_aperture"
NEAR = 0.3  # by which the effect may be larger or smaller than the other reading's, to be that


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """The other way to read, where all captures are a board's with one kind of current."""
    currents = [record.capture.get(CURRENT) for record in records]
    if not all(r.capture.program and r.capture.wiring.pwm_hz for r in records):
        return []
    means = {c.kind == "mean" for c in currents if c is not None and not c.unsigned}
    if len(means) != 1 or None in currents:
        return []
    return [_hypothesis(means.pop())]


def _hypothesis(mean: bool) -> Hypothesis:
    def declared(capture: Capture, size: float) -> list[Capture]:
        return [otherwise(capture)]

    def words(size: Floats) -> Words:
        read, said = (
            ("an instant", "a mean") if mean else ("a mean over a PWM period", "an instant")
        )
        return Words(
            "current",
            f"the current reads as {read}, and the board calls it {said}",
            "compare the kind of that channel with how its converter samples",
        )

    return Hypothesis(
        CODE, _effect, ((1.0,),), (0.1,), (1.0 - NEAR,), (1.0 + NEAR,), words, remedy=declared
    )


def _effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
    out = nothing(record)
    for k, m in enumerate(record.measured):
        if m.block.name != CURRENT:
            continue
        stated = record.outputs[m.row]
        other = replace(stated, aperture_s=_window_s(m.channel, record.pwm_period_s))
        over = record.respond(
            record.timeline.period_s, record.volts, [stated, other], record.stretches,
            record.pwm_period_s,
        )  # fmt: skip
        setup = record.setup(own)
        usual, moved = over(setup.loaded(record.motor(values), record.names), setup.initial)
        out[k] = float(size[0]) * (moved - usual)[m.where]
    return out


def _window_s(channel: Channel, pwm_period_s: float) -> float:
    """Of the other way to read."""
    return 0.0 if channel.kind == "mean" else pwm_period_s


def otherwise(capture: Capture) -> Capture:
    """The capture whose current is read in the other way."""
    current, pwm_hz = capture.channels[CURRENT], capture.wiring.pwm_hz
    assert pwm_hz
    other = replace(
        current,
        kind="instant" if current.kind == "mean" else "mean",
        aperture_s=_window_s(current, 1.0 / pwm_hz),
    )
    return replace(capture, channels={**capture.channels, CURRENT: other})
