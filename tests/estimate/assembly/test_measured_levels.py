"""What steady levels show by themselves, on a capture whose motor is known exactly."""

from __future__ import annotations

import pytest

from motorid.estimate.assembly.measured_levels import measured_levels
from motorid.motor.parameters import Motor
from motorid.segment import segment
from tests.exact_capture import FAULHABER, Plan, clean_capture
from tests.six_parameters import fit

CAPTURE = clean_capture(FAULHABER, Plan(volts=(6.0, 3.0), count=4000))


@pytest.mark.slow
def test_a_level_has_the_speed_and_current_of_the_motor_driven_for_ever() -> None:
    curves = fit([CAPTURE], model="six").curves
    m = FAULHABER
    named = [(CAPTURE, segment(CAPTURE))]
    found = measured_levels(named, curves, Motor.of(m), None)
    assert [round(level.voltage_v, 6) for level in found] == [6.0, 3.0]
    for level in found:
        speed = (m["K"] * level.voltage_v - m["R"] * m["T0"]) / (m["K"] ** 2 + m["R"] * m["B"])
        current = (m["B"] * speed + m["T0"]) / m["K"]
        assert level.speed_rad_s == pytest.approx(speed, rel=2e-3)
        assert level.current_a == pytest.approx(current, rel=2e-2)


def test_a_capture_without_a_level_has_none() -> None:
    assert measured_levels([(CAPTURE, [])], (), Motor.of(FAULHABER), None) == ()
