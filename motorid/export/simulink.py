"""Simulink: a MATLAB script that builds the model. Written, not run here."""

from __future__ import annotations

from motorid.export.motor import Motor, described

_BLOCKS = (
    ("Sources/In1", "voltage", ""),
    ("Sources/In1", "load", ""),
    ("Math Operations/Add", "volts", "'Inputs', '+--'"),
    ("Math Operations/Gain", "per_L", "'Gain', '1/L'"),
    ("Continuous/Integrator", "current", ""),
    ("Math Operations/Gain", "drop", "'Gain', 'R'"),
    ("Math Operations/Gain", "emf", "'Gain', 'K'"),
    ("Math Operations/Gain", "drive", "'Gain', 'K'"),
    ("Math Operations/Add", "torques", "'Inputs', '+---'"),
    ("Math Operations/Gain", "per_J", "'Gain', '1/J'"),
    ("Continuous/Integrator", "speed", ""),
    ("Math Operations/Gain", "viscous", "'Gain', 'B'"),
    ("User-Defined Functions/Fcn", "coulomb", "'Expr', 'T0*tanh(u/knee)'"),
    ("Sinks/Out1", "current_A", ""),
    ("Sinks/Out1", "speed_rad_s", ""),
)
_LINES = (
    ("voltage/1", "volts/1"),
    ("drop/1", "volts/2"),
    ("emf/1", "volts/3"),
    ("volts/1", "per_L/1"),
    ("per_L/1", "current/1"),
    ("current/1", "drop/1"),
    ("current/1", "drive/1"),
    ("current/1", "current_A/1"),
    ("drive/1", "torques/1"),
    ("viscous/1", "torques/2"),
    ("coulomb/1", "torques/3"),
    ("load/1", "torques/4"),
    ("torques/1", "per_J/1"),
    ("per_J/1", "speed/1"),
    ("speed/1", "emf/1"),
    ("speed/1", "viscous/1"),
    ("speed/1", "coulomb/1"),
    ("speed/1", "speed_rad_s/1"),
)


def write(motor: Motor) -> str:
    """The script's text."""
    comment = "\n".join(f"% {line}" for line in described(motor))
    values = "\n".join(
        f"assignin(w, '{name}', {motor.text(name)}); % standard uncertainty {motor.u(name):.2g}"
        for name in motor.values
    )
    blocks = "\n".join(
        f"add_block('simulink/{kind}', 'motor/{name}'{', ' + more if more else ''});"
        for kind, name, more in _BLOCKS
    )
    lines = "\n".join(f"add_line('motor', '{a}', '{b}');" for a, b in _LINES)
    return f"""% Builds the Simulink model "motor": voltage and load in, current and speed out.
% Written, not run here: compare it with a capture before you rely on it.
{comment}
new_system('motor');
w = get_param('motor', 'ModelWorkspace');
{values}
assignin(w, 'knee', {motor.knee!r}); % rad/s
{blocks}
{lines}
save_system('motor');
"""
