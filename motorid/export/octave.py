"""Octave and MATLAB: a function that returns the constants, their covariance and a state space."""

from __future__ import annotations

from motorid.export.motor import Motor, described


def write(motor: Motor) -> str:
    """The function's text."""
    comment = "\n".join(f"% {line}" for line in described(motor))
    values = "\n".join(f"  m.{name} = {motor.text(name)};" for name in motor.values)
    spread = "\n".join(f"  m.u.{name} = {motor.u(name)!r};" for name in motor.values)
    matrix = "\n    ".join(" ".join(map(repr, row)) + ";" for row in motor.covariance())
    return f"""function m = motor()
{comment}
% m.u: standard uncertainties; m.covariance: of R, L, K, B, J, T0.
% States: current (A), speed (rad/s). Inputs: voltage (V), load torque (N·m).
% m.A, m.Bu: linear; they cannot hold the Coulomb torque T0, so give it as a load.
% m.slope(x, v, load): dx/dt with the Coulomb torque.
{values}
{spread}
  m.covariance = [
    {matrix}
  ];
  m.knee = {motor.knee!r};
  m.A = [-m.R / m.L, -m.K / m.L; m.K / m.J, -m.B / m.J];
  m.Bu = [1 / m.L, 0; 0, -1 / m.J];
  m.slope = @(x, v, load) [(v - m.R * x(1) - m.K * x(2)) / m.L; ...
    (m.K * x(1) - m.B * x(2) - m.T0 * tanh(x(2) / m.knee) - load) / m.J];
end
"""
