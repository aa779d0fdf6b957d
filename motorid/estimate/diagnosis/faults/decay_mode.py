"""A bridge that passes the off part of a PWM period in another way than the program says.

Slow decay shorts the motor, fast decay reverses the supply, and diodes do that only while a current
flows. Where the volts are commanded, the two switched modes differ by what the dead time takes.
Where they are measured, diodes differ from both by a current that stops within the period.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from motorid.capture.model import Capture
from motorid.estimate.diagnosis.fault import Hypothesis, Words
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.reconstructed_voltage import Driving
from motorid.estimate.signals.source.discontinuous_current import divided
from motorid.estimate.signals.source.pwm_bridge import SWITCHED
from motorid.estimate.signals.standstill import with_standstill
from motorid.estimate.signals.time_grid import lay
from motorid.program import Decay

Floats = NDArray[np.float64]

CODE = "decay_contradicted"
NEAR = 0.3  # by which the effect may be larger or smaller than the other mode's, to be that
NAMES = {Decay.SYNCHRONOUS_SLOW: "slow", Decay.FAST: "fast", Decay.DIODE: "diode"}


def hypotheses(records: Sequence[MotorRecord]) -> list[Hypothesis]:
    """The other modes that the readings could tell, where the steps of all captures say one."""
    stated = {s.decay for r in records if r.capture.program for s in r.capture.program.steps}
    stated -= {Decay.NONE}
    if len(stated) != 1 or not all(r.capture.program and r.capture.wiring.pwm_hz for r in records):
        return []
    (claimed,) = stated
    others = [real for real in NAMES if real != claimed]
    return [_hypothesis(claimed, o) for o in others if all(_told(r, {claimed, o}) for r in records)]


def _told(record: MotorRecord, modes: set[Decay]) -> bool:
    """The readings tell these two modes apart."""
    if record.sensed.commanded:
        return modes <= set(SWITCHED)
    return record.sensed.shows_emf and Decay.DIODE in modes


def _hypothesis(claimed: Decay, real: Decay) -> Hypothesis:
    def declared(capture: Capture, size: float) -> list[Capture]:
        return [with_decay(capture, real)]

    others: dict[int, MotorRecord] = {}  # by the identity of a record that is tried

    def effect(record: MotorRecord, values: Floats, own: Floats, size: Floats) -> list[Floats]:
        """To first order: what drives is judged where it is tried first, as for any fit."""
        if id(record) not in others:
            driving = _under(record, with_decay(record.capture, real))
            driving = driving.judged(record.course(values, own), record.losing)
            others[id(record)] = record.twin(driving.excitation)
        usual, moved = (r.fitted(values, own) for r in (record, others[id(record)]))
        return [float(size[0]) * (b - a) for a, b in zip(usual, moved, strict=True)]

    def words(size: Floats) -> Words:
        return Words(
            "bridge",
            f"the current runs as with {NAMES[real]} decay, and the program's steps say "
            f"{NAMES[claimed]}",
            "compare the decay of the program's steps with the mode of the bridge's driver",
        )

    return Hypothesis(
        CODE, effect, ((1.0,),), (0.1,), (1.0 - NEAR,), (1.0 + NEAR,), words, remedy=declared
    )


def _under(record: MotorRecord, capture: Capture) -> Driving:
    """What drives the record if the bridge is as ``capture``, of the same readings, says."""
    timeline = divided(capture, with_standstill(capture, lay(capture)), record.sensed)
    return Driving.of(capture, timeline, record.sensed)


def with_decay(capture: Capture, decay: Decay) -> Capture:
    """The capture whose drive steps say that decay."""
    assert capture.program is not None
    steps = tuple(
        s if s.decay == Decay.NONE else replace(s, decay=decay) for s in capture.program.steps
    )
    return replace(capture, program=replace(capture.program, steps=steps))
