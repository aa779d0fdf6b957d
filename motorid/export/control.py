"""python-control: a Python module with the motor as a linear and as a nonlinear system."""

from __future__ import annotations

from motorid.export.motor import Motor, described


def write(motor: Motor) -> str:
    """The module's text."""
    comment = "\n".join(f"# {line}" for line in described(motor))
    values = "\n".join(f'    "{name}": {motor.text(name)},' for name in motor.values)
    spread = "\n".join(f'    "{name}": {motor.u(name)!r},' for name in motor.values)
    matrix = "\n".join(f"    {row!r}," for row in motor.covariance())
    return f'''{comment}
"""A brushed DC motor for python-control: voltage and load torque in, current and speed out."""

import control
import numpy as np

MOTOR = {{
{values}
}}
STANDARD_UNCERTAINTY = {{
{spread}
}}
COVARIANCE = [  # of R, L, K, B, J, T0
{matrix}
]
KNEE = {motor.knee!r}  # rad/s at which the Coulomb torque has 76 % of its size
NAMES = dict(inputs=["voltage", "load"], outputs=["current", "speed"], states=["current", "speed"])


def linear(R, L, K, B, J, T0):
    """The state space. A linear system cannot hold the Coulomb torque T0: subtract it as a load."""
    a = [[-R / L, -K / L], [K / J, -B / J]]
    b = [[1 / L, 0], [0, -1 / J]]
    return control.ss(a, b, np.eye(2), np.zeros((2, 2)), name="motor", **NAMES)


def nonlinear(R, L, K, B, J, T0):
    """The same with the Coulomb torque, as a nonlinear input/output system."""

    def slope(t, x, u, params):
        current, speed = x
        friction = B * speed + T0 * np.tanh(speed / KNEE)
        return np.array(
            [(u[0] - R * current - K * speed) / L, (K * current - friction - u[1]) / J]
        )

    return control.nlsys(slope, None, name="motor", **NAMES)


def draws(count, seed=0):
    """Motors that the estimate's covariance allows: dictionaries as MOTOR."""
    rng = np.random.default_rng(seed)
    drawn = rng.multivariate_normal(list(MOTOR.values()), COVARIANCE, size=count)
    return [dict(zip(MOTOR, np.maximum(row, 0.0))) for row in drawn]
'''
