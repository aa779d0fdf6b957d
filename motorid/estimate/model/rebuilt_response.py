"""A response of its own for a run that the one which stands cannot be changed into."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from motorid.estimate.effects.action import Setup, restretched
from motorid.motor.response import Response

if TYPE_CHECKING:
    from motorid.estimate.model.capture_model import MotorRecord


def rebuilt(record: MotorRecord, setup: Setup, respond: Callable[..., Response]) -> Response:
    """With another clock, gain of the source, or other stretches; ``respond`` makes it."""
    clock, gain = setup.clock, setup.source_gain
    outputs = [
        replace(o, aperture_s=clock * o.aperture_s, delay_s=clock * o.delay_s)
        for o in record.outputs
    ]
    for m in record.measured:
        late = setup.late_s.get(m.block.name, 0.0)
        as_read = outputs[m.row].delayed(late, record.pwm_period_s)
        filter_s = as_read.filter_s + setup.filter_s.get(m.block.name, 0.0)
        outputs[m.row] = replace(as_read, filter_s=filter_s)
    stretches = [
        replace(s, swing_v=gain * s.swing_v, clamp_v=gain * s.clamp_v)
        for s in restretched(record.stretches, record.timeline.parts, setup.stretched)
    ]
    for part, kick in setup.kicks.items():
        k = record.first[part]
        stretches[k] = replace(stretches[k], kick_rad_s=kick)
    volts = gain * (record.volts + record.stamped(setup)) + setup.volts
    period_s = clock * record.timeline.period_s
    return respond(period_s, volts, outputs, stretches, clock * record.pwm_period_s)
