"""Simscape: a component of the language's own (.ssc). Written, not run here."""

from __future__ import annotations

from motorid.export.motor import Motor, described

_UNITS = {"R": "Ohm", "L": "H", "K": "N*m/A", "B": "N*m*s/rad", "J": "kg*m^2", "T0": "N*m"}


def write(motor: Motor) -> str:
    """The component's text."""
    comment = "\n".join(f"% {line}" for line in described(motor))
    values = "\n".join(
        f"    {name} = {{{motor.text(name)}, '{_UNITS[name]}'}}; "
        f"% standard uncertainty {motor.u(name):.2g}"
        for name in motor.values
    )
    return f"""component motor
% Brushed DC motor
% Written, not run here: compare it with a capture before you rely on it.
{comment}
  nodes
    p = foundation.electrical.electrical; % +
    n = foundation.electrical.electrical; % -
    shaft = foundation.mechanical.rotational.rotational;
    frame = foundation.mechanical.rotational.rotational;
  end
  parameters
{values}
    knee = {{{motor.knee!r}, 'rad/s'}};
  end
  variables
    i = {{0, 'A'}};
    w = {{0, 'rad/s'}};
    t = {{0, 'N*m'}};
  end
  branches
    i : p.i -> n.i;
    t : frame.t -> shaft.t;
  end
  equations
    w == shaft.w - frame.w;
    p.v - n.v == R*i + L*der(i) + K*w;
    J*der(w) == K*i - B*w - T0*tanh(w/knee) - t;
  end
end
"""
