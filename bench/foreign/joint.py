"""A motor whose mechanics are a hinge of MuJoCo and whose windings are its DC-motor actuator.

A linear amplifier drives it: the actuator's voltage is that of the step, without a PWM. To coast, a
relay opens; two diodes carry the current to zero, and the actuator is switched off.

MuJoCo integrates the current exactly over a step at the speed of its beginning, and friction loss
as a constraint. Its reference is as short as a step allows: with the usual one, dry friction pushes
a rotor on that is braked hard. Windage is an applied force. Load-dependent friction is a friction
loss that follows the current.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bench.foreign.chain import Trace
from bench.foreign.drawn import Rig
from motorid.program import Step, StepKind

Floats = NDArray[np.float64]
STEP_S = 4e-6  # its half is the error of the speed's time
DIODES_V = 1.4
MODEL = """<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody>
    <body>
      <joint name="shaft" type="hinge" axis="0 0 1" armature="{J!r}" damping="{B!r}"
             frictionloss="{T0!r}" solreffriction="{reference!r} 1"/>
      <inertial pos="0 0 0" mass="1e-3" diaginertia="1e-14 1e-14 1e-14"/>
    </body>
  </worldbody>
  <actuator>
    <dcmotor joint="shaft" motorconst="{K!r}" resistance="{R!r}" inductance="{L!r}"/>
  </actuator>
</mujoco>"""


def available() -> bool:
    """True where MuJoCo can be imported."""
    return importlib.util.find_spec("mujoco") is not None


def run(rig: Rig, folder: Path) -> Trace:
    """The rig's program from rest; ``folder`` is not used."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        MODEL.format(step=STEP_S, reference=2 * STEP_S, **rig.truth)
    )
    data = mujoco.MjData(model)
    parts, begun = [np.zeros((1, 4))], 0.0
    for step in rig.program.steps:
        length = step.duration_s / (1 + rig.clock_error)
        count = round(length / STEP_S)
        model.opt.timestep = length / count
        rows = _step(mujoco, model, data, rig, step, count)
        rows[:, 0] = begun + model.opt.timestep * np.arange(1, count + 1)
        # the voltage jumps where the step begins
        parts += [np.array([[begun, parts[-1][-1, 1], rows[0, 2], parts[-1][-1, 3]]]), rows]
        begun += length
    return Trace(*np.concatenate(parts).T)


def _step(mujoco: Any, model: Any, data: Any, rig: Rig, step: Step, count: int) -> Floats:
    """Rows of time (left open), current, terminal voltage and speed."""
    K, T0 = rig.truth["K"], rig.truth["T0"]
    square = rig.iron.windage * rig.truth["B"] / rig.idle_rad_s
    load, coasts = rig.iron.load_friction * K, step.kind == StepKind.COAST
    volts = step.level if step.kind == StepKind.DRIVE_VOLTS else 0.0
    rows, off = np.zeros((count, 4)), False
    sign = np.sign(data.act[0])
    for n in range(count):
        current, speed = data.act[0], data.qvel[0]
        if coasts and (off or current * sign <= 0.0):
            off, current, volts = True, 0.0, K * speed
            data.act[0] = 0.0
            data.ctrl[0] = volts  # the actuator's own current stays nothing
        else:
            volts = -sign * (rig.supply_v + DIODES_V) if coasts else volts
            data.ctrl[0] = volts
        if load:
            model.dof_frictionloss[0] = T0 + load * abs(current)
        if square:
            data.qfrc_applied[0] = -square * abs(speed) * speed
        mujoco.mj_step(model, data)
        rows[n, 1:] = (0.0 if off else data.act[0]), volts, data.qvel[0]
    return rows
