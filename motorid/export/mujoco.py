"""MuJoCo: an MJCF model with a hinge and its DC motor, whose control is in volts.

Needs MuJoCo 3.7 or newer, which has the actuator ``dcmotor``. ``motorconst`` takes the torque and
the back-EMF constant, which are one; the rotor's inertia is the joint's ``armature``.
"""

from __future__ import annotations

from motorid.export.motor import Motor, described

STEP_S = 1e-4  # at most; a fifth of L/R where that is shorter
NEGLIGIBLE = 1e-6  # of the inertia: MuJoCo wants some in every body that moves


def write(motor: Motor) -> str:
    """The model's text."""
    R, L, K, B, J, T0 = (motor.text(name) for name in motor.values)
    winding = f' inductance="{L} 0"' if motor.number("L") else ""
    electrical_s = motor.number("L") / motor.number("R")
    step = min(STEP_S, electrical_s / 5.0) if electrical_s else STEP_S
    body = repr(NEGLIGIBLE * motor.number("J"))
    comment = "\n  ".join(described(motor))
    return f"""<mujoco model="motor">
  <!--
  {comment}
  In your own model: the joint's damping, frictionloss and armature, and the dcmotor; control in V.
  Take an Euler or implicitfast integrator: with RK4 the current is some percent off.
  -->
  <option timestep="{step!r}" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <body name="rotor">
      <inertial pos="0 0 0" mass="1e-3" diaginertia="{body} {body} {body}"/>
      <joint name="shaft" type="hinge" axis="0 0 1" damping="{B}" frictionloss="{T0}" armature="{J}"
             solreffriction="{2.0 * step!r} 1" solimpfriction="0.9999 0.9999 0.001"/>
    </body>
  </worldbody>
  <actuator>
    <dcmotor name="motor" joint="shaft" motorconst="{K} {K}" resistance="{R}"{winding}/>
  </actuator>
  <sensor>
    <jointvel name="speed" joint="shaft"/>
    <actuatorfrc name="torque" actuator="motor"/>
  </sensor>
</mujoco>
"""
