"""The mean current of a switched winding in iron, against the switched circuit itself.

The response follows means; the PWM's ripple lies about them. Where the duty jumps, so does the
offset of the mean from the currents at the edges, by a flux: in iron that saturates it is a larger
current than at no current.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.wide import AT_REST, NAMES, WideResponse

Floats = NDArray[np.float64]

PERIOD_S, PWM_S = 1e-4, 5e-5
RAIL_V, DUTY = 34.0, 0.8
MOTOR = {"R": 1.2, "L": 3.4e-4, "K": 1e-3, "B": 0.0, "J": 1.0, "T0": 1.0}  # friction holds it
SATURATION = {"saturation": 0.6, "saturation_current": 12.0}
EDDY = {"eddy": 0.4, "eddy_time": 3e-4}
SIGNS = (1,) * 15 + (-1,) * 12 + (1,) * 8  # of the drive, one a sample
STEPS = 100  # of a PWM period, by the trapezoid's rule below
EXACT = 1e-3  # of the largest current: the wave grows within a period, and the model's does not


def slopes(state: Floats, volts: float, motor: dict[str, float]) -> Floats:
    """d/dt of the winding's current and of the shielded one."""
    share, knee = motor.get("eddy", 0.0), motor.get("saturation_current", 1.0)
    left = 1.0 - motor.get("saturation", 0.0) * state**2 / (state**2 + knee**2)
    shield = motor["L"] * share / motor["eddy_time"] if share else 0.0
    shielded = shield * (state[0] - state[1])
    winding = (volts - motor["R"] * state[0] - shielded) / (motor["L"] * (1 - share) * left[0])
    return np.array([winding, shielded / (motor["L"] * share * left[1]) if share else 0.0])


def switched(motor: dict[str, float]) -> Floats:
    """Mean current of the last PWM period before each tick: Heun's method on the switched drive."""
    state, step, means = np.zeros(2), PWM_S / STEPS, [0.0]
    for sign in SIGNS:
        for _ in range(round(PERIOD_S / PWM_S)):
            charge = 0.0
            for k in range(STEPS):
                volts = sign * RAIL_V if k < DUTY * STEPS else 0.0
                first = slopes(state, volts, motor)
                second = slopes(state + step * first, volts, motor)
                after = state + step / 2 * (first + second)
                charge += step / 2 * (state[0] + after[0])
                state = after
        means.append(charge / PWM_S)
    return np.array(means)


@pytest.mark.slow
@pytest.mark.parametrize("iron", [{}, SATURATION, EDDY, SATURATION | EDDY])
def test_the_mean_current_is_that_of_the_switched_circuit(iron: dict[str, float]) -> None:
    motor = MOTOR | iron
    turns = [1, *(k + 1 for k in range(1, len(SIGNS)) if SIGNS[k] != SIGNS[k - 1])]
    plan = [Stretch(0, True)]
    plan += [Stretch(k, duty=DUTY, swing_v=SIGNS[k - 1] * RAIL_V) for k in turns]
    volts = np.array([0.0, *(DUTY * RAIL_V * sign for sign in SIGNS)])
    response = WideResponse(PERIOD_S, volts, [Output(Quantity.CURRENT, PWM_S)], plan, PWM_S)
    vector = [motor.get(name, 0.0) for name in NAMES]
    response.plan(vector, AT_REST)
    true = switched(motor)
    np.testing.assert_allclose(response(vector)[0], true, atol=EXACT * np.abs(true).max())
