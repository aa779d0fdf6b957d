"""Figures that follow from the parameters, against brute force and at their limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.motor.parameters import Motor, no_load_speed, peak_efficiency

MOTOR = Motor(2.6, 180e-6, 7.68e-3, 2e-7, 3.9e-7, 4e-4)


def test_peak_efficiency_is_the_best_of_all_speeds() -> None:
    m, volts = MOTOR, 6.0
    speeds = np.linspace(0, no_load_speed(m, volts), 20_001)[1:-1]
    amps = (volts - m.K * speeds) / m.R
    best = (speeds * (m.K * amps - m.B * speeds - m.T0) / (volts * amps)).max()
    assert peak_efficiency(m, volts) == pytest.approx(best, rel=1e-6)


@pytest.mark.parametrize("friction", [0.0, 1e-15, 1e-11])
def test_a_motor_without_friction_loses_nothing_at_no_load(friction: float) -> None:
    free = replace(MOTOR, B=0.0, T0=friction)
    assert peak_efficiency(free, 6.0) == pytest.approx(1.0, abs=1e-3)
