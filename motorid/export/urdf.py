"""URDF: a link that turns, with the rotor's inertia and the joint's friction."""

from __future__ import annotations

from motorid.export.motor import Motor, described


def write(motor: Motor) -> str:
    """The robot's text."""
    comment = "\n  ".join(described(motor))
    J = motor.text("J")
    return f"""<?xml version="1.0" encoding="utf-8"?>
<robot name="motor">
  <!--
  {comment}
  URDF has no electrical side: drive the joint by the torque K i.
  -->
  <link name="stator"/>
  <link name="shaft">
    <inertial>
      <mass value="0.001"/>
      <inertia ixx="{J}" iyy="{J}" izz="{J}" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="turn" type="continuous">
    <parent link="stator"/>
    <child link="shaft"/>
    <axis xyz="0 0 1"/>
    <dynamics damping="{motor.text("B")}" friction="{motor.text("T0")}"/>
  </joint>
</robot>
"""
