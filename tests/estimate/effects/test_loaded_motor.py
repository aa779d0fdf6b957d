"""A resistor across the motor: the circuit itself against the motor that its readings show."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.effects.loaded_motor import loaded
from motorid.estimate.results.estimate import PARAMETERS

MOTOR = np.array([2.4, 1.8e-3, 0.045, 8e-6, 1.2e-5, 5e-3])
LOAD_OHM = 300.0
SPEED = 180.0  # rad/s


def shown() -> np.ndarray:
    return loaded(MOTOR, PARAMETERS, 1.0 / LOAD_OHM)


@pytest.mark.parametrize("volts", [0.0, 6.0, 24.0])  # shorted, driven
def test_driven_the_current_and_the_torque_are_the_circuits(volts: float) -> None:
    R, _, K, B, _, _ = MOTOR
    own = (volts - K * SPEED) / R
    seen = own + volts / LOAD_OHM
    r, _, k, b, _, _ = shown()
    assert (volts - k * SPEED) / r == pytest.approx(seen)
    assert k * seen - b * SPEED == pytest.approx(K * own - B * SPEED)


def test_open_the_resistor_brakes_and_takes_from_the_back_emf() -> None:
    R, _, K, B, _, _ = MOTOR
    flows = K * SPEED / (R + LOAD_OHM)
    _, _, k, b, _, _ = shown()
    assert k * SPEED == pytest.approx(LOAD_OHM * flows)
    assert b * SPEED == pytest.approx(B * SPEED + K * flows)


def test_inertia_and_dry_friction_stay_and_nothing_changes_nothing() -> None:
    assert shown()[4:] == pytest.approx(MOTOR[4:])
    assert loaded(MOTOR, PARAMETERS, 0.0) is MOTOR


def test_the_integral_of_a_steps_current_is_that_of_its_inductance() -> None:
    """The sensor shows v/R_p at once, and the winding's current late by L/R."""
    R, L, *_ = MOTOR
    time = np.linspace(0.0, 30.0 * L / R, 60_001)
    seen = (1.0 - np.exp(-R * time / L)) / R + 1.0 / LOAD_OHM
    r, henry, *_ = shown()
    alone = (1.0 - np.exp(-r * time / henry)) / r
    lacks = np.trapezoid(seen[-1] - seen, time)
    assert np.trapezoid(alone[-1] - alone, time) == pytest.approx(lacks, rel=1e-6)
