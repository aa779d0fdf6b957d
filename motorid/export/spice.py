"""SPICE: a subcircuit of winding, back-EMF and rotor, in the syntax of ngspice.

A node's voltage is the speed (1 V is 1 rad/s), its capacitor the inertia, and current into it a
torque (1 A is 1 N·m). The Coulomb torque is a tanh of the speed, for a jump has no derivative.
"""

from __future__ import annotations

from motorid.export.motor import Motor, described


def write(motor: Motor) -> str:
    """The subcircuit's text."""
    given = "\n".join(f"+ {name}={motor.text(name)}" for name in motor.values)
    spread = "\n".join(f"*   u_{name} = {motor.u(name)!r}" for name in motor.values)
    comment = "\n".join(f"* {line}" for line in described(motor))
    return f"""* subcircuit motor
{comment}
* Standard uncertainties, to draw values around those of the parameters:
{spread}
* Pins: p and n the terminals; shaft: V(shaft) is the speed in rad/s, a current that is drawn from
* it a load torque in N·m.
.subckt motor p n shaft
{given}
+ knee={motor.knee!r}
Vsense p a 0
Rwinding a b {{R}}
Lwinding b c {{L}}
Eemf c n shaft 0 {{K}}
Fdrive 0 shaft Vsense {{K}}
Cinertia shaft 0 {{J}} ic=0
Bfriction shaft 0 i={{B}}*v(shaft)+{{T0}}*tanh(v(shaft)/{{knee}})
.ends motor
"""
