"""A response of its own for a run that the one which stands cannot be changed into."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motorid.estimate.effects.action import Setup, restretched
from motorid.estimate.signals.measurements import Measured
from motorid.estimate.signals.time_grid import Timeline
from motorid.motor.reading import Output, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import AT_REST, NAMES, WideResponse

DIFFERENCE = 1e-9  # of the largest current and speed: a derivative is a difference of responses
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Planned:
    """The steps of a run: of that motor from that state, driven by those volts."""

    motor: Floats
    initial: Floats
    volts: Floats
    levels: NDArray[np.uint8]

    def serve(self, motor: Floats, initial: Floats, volts: Floats) -> bool:
        """For a motor that has as much more as the planned one, or less: on the same steps the
        difference of the two is smooth.
        """
        same = np.array_equal(np.abs(motor), np.abs(self.motor))
        return same and volts is self.volts and np.array_equal(initial, self.initial)


class Driven(Protocol):
    """A record as far as a response of its run needs it; as of ``MotorRecord``."""

    planned: Planned | None

    @property
    def volts(self) -> Floats: ...
    @property
    def stretches(self) -> Sequence[Stretch]: ...
    @property
    def first(self) -> Mapping[int, int] | Sequence[int]: ...
    @property
    def outputs(self) -> Sequence[Output]: ...
    @property
    def measured(self) -> tuple[Measured, ...]: ...
    @property
    def pwm_period_s(self) -> float: ...
    @property
    def states(self) -> int: ...
    @property
    def timeline(self) -> Timeline: ...
    def stamped(self, setup: Setup) -> Floats | float: ...


def rebuilt(record: Driven, setup: Setup, respond: Callable[..., Response]) -> Response:
    """With another clock, gain of the source, or other stretches; ``respond`` makes it."""
    clock, gain = setup.clock, setup.source_gain
    outputs = list(record.outputs)
    if clock != 1.0:
        outputs = [
            replace(o, aperture_s=clock * o.aperture_s, delay_s=clock * o.delay_s) for o in outputs
        ]
    for m in record.measured:
        name = m.block.name
        late, slower = setup.late_s.get(name, 0.0), setup.filter_s.get(name, 0.0)
        if late or slower or name in setup.second_s:
            as_read = outputs[m.row].delayed(late, record.pwm_period_s)
            # it is part of the one of second order, where there is one
            filter_s = 0.0 if name in setup.second_s else as_read.filter_s + slower
            outputs[m.row] = replace(as_read, filter_s=filter_s)
    stretches = restretched(record.stretches, record.timeline.parts, setup.stretched)
    if gain != 1.0:
        stretches = [
            replace(s, swing_v=gain * s.swing_v, clamp_v=gain * s.clamp_v) for s in stretches
        ]
    for part, kick in setup.kicks.items():
        k = record.first[part]
        stretches[k] = replace(stretches[k], kick_rad_s=kick)
    volts = gain * (record.volts + record.stamped(setup)) + setup.volts
    period_s = clock * record.timeline.period_s
    return respond(period_s, volts, outputs, stretches, clock * record.pwm_period_s)


def extended(record: Driven, motor: Floats, setup: Setup) -> Floats:
    """Readings (outputs, count) with parameters beyond the six, by the response that knows them.

    ``motor``: the first of ``motorid.motor.wide.NAMES``; the others are none but for the setup's.
    """
    wider, initial = np.zeros(len(NAMES)), [*setup.initial, *AT_REST[record.states :]]
    wider[: len(motor)] = motor
    wider = setup.onto(wider, NAMES)
    response, state = rebuilt(record, setup, WideResponse), np.array(initial)
    assert isinstance(response, WideResponse)
    if record.planned is not None and record.planned.serve(wider, state, record.volts):
        response.levels = record.planned.levels
    else:
        response.plan(wider, initial, DIFFERENCE)
        record.planned = Planned(wider, state, record.volts, response.levels)
    return response(wider, initial)
