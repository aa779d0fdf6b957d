"""Each target that can be run here is run, and moves as the capture did."""

from __future__ import annotations

import runpy
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.export.targets import export
from tests.export.driven import PERIOD_S, Driven, made

pytestmark = pytest.mark.slow
GEAR = 20.0


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Driven:
    return made(tmp_path_factory.mktemp("driven"))


@pytest.mark.parametrize("gear", [1.0, GEAR])
def test_mujoco(driven: Driven, gear: float) -> None:
    import mujoco

    text = export(driven.path, "mujoco", gear_ratio=gear).content.decode()
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    rows = np.zeros((len(driven.volts), 2))
    parts = round(PERIOD_S / model.opt.timestep)
    assert parts * model.opt.timestep == pytest.approx(PERIOD_S)
    for k, volts in enumerate(driven.volts):
        rows[k] = data.act[-1], gear * data.qvel[0]
        data.ctrl[0] = volts
        mujoco.mj_step(model, data, nstep=parts)
    driven.insist(*rows.T)


def test_urdf_driven_by_the_torque(driven: Driven) -> None:
    import mujoco

    spec = mujoco.MjSpec.from_string(export(driven.path, "urdf").content.decode())
    parts = 10
    spec.option.timestep, spec.option.gravity = PERIOD_S / parts, [0.0, 0.0, 0.0]
    model = spec.compile()
    # URDF says nothing of how stiff friction is, and MuJoCo's own choice is soft
    model.dof_solref[:], model.dof_solimp[:, :3] = [2e-4, 1.0], [0.9999, 0.9999, 0.001]
    data = mujoco.MjData(model)
    torque = driven.estimate.parameters["K"].value * driven.mean_current
    speed = np.zeros(len(torque))
    for k in range(1, len(torque)):
        data.qfrc_applied[0] = torque[k]
        mujoco.mj_step(model, data, nstep=parts)
        speed[k] = data.qvel[0]
    driven.insist(None, speed)


def test_ngspice(driven: Driven, tmp_path: Path) -> None:
    if not shutil.which("ngspice"):
        pytest.skip("no ngspice")
    (tmp_path / "motor.lib").write_bytes(export(driven.path, "spice").content)
    edge, corners = 1e-7, ["0 0"]
    for k in np.flatnonzero(np.diff(driven.volts)) + 1:
        at = k * PERIOD_S
        corners += [f"{at:.9f} {driven.volts[k - 1]}", f"{at + edge:.9f} {driven.volts[k]}"]
    (tmp_path / "run.cir").write_text(
        "* run\n.include motor.lib\nV1 p 0 PWL(" + " ".join(corners) + ")\nX1 p 0 w motor\n"
        f".control\ntran 50u {len(driven.volts) * PERIOD_S} 0 50u uic\n"
        "wrdata out.txt v(w) i(V1)\nquit\n.endc\n.end\n"
    )
    subprocess.run(
        ["ngspice", "-b", "run.cir"], cwd=tmp_path, check=True, capture_output=True, timeout=300
    )
    time, speed, _, drawn = np.loadtxt(tmp_path / "out.txt").T
    driven.insist(-np.interp(driven.time_s, time, drawn), np.interp(driven.time_s, time, speed))


def test_control(driven: Driven, tmp_path: Path) -> None:
    import control

    (tmp_path / "motor.py").write_bytes(export(driven.path, "control").content)
    told: dict[str, Any] = runpy.run_path(str(tmp_path / "motor.py"))
    linear = told["linear"](**told["MOTOR"])
    # a linear system has no Coulomb torque: given as a load that opposes the measured speed
    load = np.where(np.abs(driven.speed) > 1.5, np.sign(driven.speed), 0.0) * told["MOTOR"]["T0"]
    answer = control.forced_response(
        control.c2d(linear, PERIOD_S, "zoh"), driven.time_s, np.stack([driven.volts, load])
    )
    driven.insist(*answer.outputs)
    own = told["nonlinear"](**told["MOTOR"])
    slope = own.dynamics(0.0, np.array([0.5, 100.0]), np.array([3.0, 0.0]))
    M = told["MOTOR"]
    assert slope == pytest.approx(
        [
            (3.0 - 0.5 * M["R"] - 100 * M["K"]) / M["L"],
            (0.5 * M["K"] - 100 * M["B"] - M["T0"]) / M["J"],
        ]
    )
    drawn = np.array([list(one.values()) for one in told["draws"](4000)])
    u = [driven.estimate.parameters[name].total for name in M]
    assert drawn.std(axis=0) == pytest.approx(u, rel=0.1)


@pytest.mark.parametrize("gear", [1.0, GEAR])
def test_fmu(driven: Driven, tmp_path: Path, gear: float) -> None:
    if not shutil.which("cc"):
        pytest.skip("no C compiler cc: the FMU holds no binary")
    import fmpy
    from fmpy.validation import validate_fmu

    path = tmp_path / "motor.fmu"
    path.write_bytes(export(driven.path, "fmu", gear_ratio=gear).content)
    assert validate_fmu(str(path)) == []
    signals = np.array(
        list(zip(driven.time_s, driven.volts, strict=True)),
        dtype=[("time", float), ("voltage", float)],
    )
    answer = fmpy.simulate_fmu(
        str(path), input=signals, output=["current", "speed"], stop_time=driven.time_s[-1],
        output_interval=PERIOD_S, step_size=PERIOD_S,
    )  # fmt: skip
    driven.insist(answer["current"], gear * answer["speed"])


def test_octave(driven: Driven, tmp_path: Path) -> None:
    if not shutil.which("octave-cli"):
        pytest.skip("no octave")
    (tmp_path / "motor.m").write_bytes(export(driven.path, "octave").content)
    np.savetxt(tmp_path / "volts.txt", driven.volts)
    (tmp_path / "run.m").write_text(
        f"m = motor(); v = load('volts.txt'); parts = 20; h = {PERIOD_S} / parts;\n"
        "x = [0; 0]; out = zeros(numel(v), 2);\n"
        "for k = 1:numel(v)\n  out(k, :) = x';\n  for j = 1:parts\n"
        "    half = x + h / 2 * m.slope(x, v(k), 0); x = x + h * m.slope(half, v(k), 0);\n"
        "  end\nend\nsave('-ascii', 'out.txt', 'out'); assert(size(m.covariance), [6 6]);\n"
    )
    subprocess.run(["octave-cli", "--no-init-file", "run.m"], cwd=tmp_path, check=True, timeout=300)
    driven.insist(*np.loadtxt(tmp_path / "out.txt").T)
