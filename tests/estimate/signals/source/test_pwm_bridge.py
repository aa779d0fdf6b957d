"""The wave of the current within a PWM period, against the simulated bridge with its dead time."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import Wiring
from motorid.estimate.signals.source.pwm_bridge import stretch_of
from motorid.estimate.signals.time_grid import Part
from motorid.motor.reading import Output, Quantity
from motorid.motor.response import Response
from motorid.program import Decay, StepKind
from tests.sim.conftest import make_plant

R, L, SUPPLY, T = 2.0, 400e-6, 12.0, 50e-6
SLOW, FAST = Decay.SYNCHRONOUS_SLOW, Decay.FAST
BRIDGE = Wiring(pwm_hz=1 / T, dead_time_s=1e-6)
PHASES = np.arange(10) / 10 + 0.05


@pytest.mark.parametrize(
    ("decay", "duty", "in_time"),
    [
        (SLOW, 0.4, False),
        (SLOW, -0.7, False),
        (FAST, 0.4, False),
        (FAST, -0.4, False),
        (FAST, 0.05, True),  # ripple turns the current round
        (FAST, -0.05, True),
    ],
)
def test_the_wave_of_a_bridge_with_dead_time(decay: Decay, duty: float, in_time: bool) -> None:
    """A locked motor in its periodic state: instants over the period, and the mean voltage."""
    plant = make_plant(dead_time=BRIDGE.dead_time_s, diode_drop=0.7)
    plant.lock()
    plant.drive(duty, decay=int(decay))
    plant.advance(400 * T)
    plant.clear()
    plant.advance(T)
    mean, volts = plant.c.i_dt / T, plant.c.v_dt / T
    seen, now = [], 0.0
    for phase in PHASES:
        plant.advance((phase - now) * T)
        seen.append(plant.c.current)
        now = phase
    part = Part(0, 400, StepKind.DRIVE_DUTY, duty, decay)
    source = np.full(400, volts)
    stretch = stretch_of(BRIDGE, SUPPLY, SUPPLY + 1.4, part, 0, 0.0, source, in_time)
    outputs = [Output(Quantity.CURRENT, pwm_phase=float(phase)) for phase in PHASES]
    locked = (R, L, 1e-9, 0.0, 1e3, 1e6)
    model = Response(T, source, outputs, [stretch], T)(locked)[:, -1]
    ripple = float(np.ptp(seen))
    assert model == pytest.approx(np.array(seen), abs=5e-4 * ripple)
    assert np.abs(np.array(seen) - mean).max() > 0.4 * ripple
