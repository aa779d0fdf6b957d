"""Modelica: a model on the standard library's connectors. Written, not run here."""

from __future__ import annotations

from motorid.export.motor import Motor, described

_TYPES = {
    "R": "SI.Resistance",
    "L": "SI.Inductance",
    "K": "SI.ElectricalTorqueConstant",
    "B": "SI.RotationalDampingConstant",
    "J": "SI.Inertia",
    "T0": "SI.Torque",
}


def write(motor: Motor) -> str:
    """The model's text."""
    comment = "\n".join(f"// {line}" for line in described(motor))
    values = "\n".join(
        f"  parameter {_TYPES[name]} {name} = {motor.text(name)} "
        f'"standard uncertainty {motor.u(name):.2g}";'
        for name in motor.values
    )
    return f"""{comment}
// Written, not run here: compare it with a capture before you rely on it.
model Motor "Brushed DC motor"
  import SI = Modelica.Units.SI;
{values}
  parameter SI.AngularVelocity knee = {motor.knee!r}
    "speed at which the Coulomb torque has 76 % of its size";
  Modelica.Electrical.Analog.Interfaces.PositivePin p;
  Modelica.Electrical.Analog.Interfaces.NegativePin n;
  Modelica.Mechanics.Rotational.Interfaces.Flange_b shaft;
  SI.Current i(start = 0, fixed = true);
  SI.AngularVelocity w(start = 0, fixed = true);
equation
  p.i = i;
  p.i + n.i = 0;
  p.v - n.v = R*i + L*der(i) + K*w;
  der(shaft.phi) = w;
  J*der(w) = K*i - B*w - T0*tanh(w/knee) + shaft.tau;
end Motor;
"""
