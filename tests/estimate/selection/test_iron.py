"""Iron and load friction by the simulated rig, whose plant shares no code with the fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire.record import capture as record
from motorid.capture import store
from motorid.capture.model import Capture
from motorid.estimate.model.extended_terms import ADDED
from motorid.estimate.results.estimate import Estimate, Parameter
from motorid.estimate.selection import measurands
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import load_rig
from motorid.sim import truth
from tests.six_parameters import fit

SLOW = Decay.SYNCHRONOUS_SLOW


def program(*volts: float, drive_s: float = 0.06, coast_s: float = 0.3) -> Program:
    drives = [Step(StepKind.DRIVE_VOLTS, drive_s, v, SLOW) for v in volts]
    return Program((Step(StepKind.COAST, 0.03), *drives, Step(StepKind.COAST, coast_s)))


def measured(folder: Path, options: str, run: Program) -> tuple[Capture, dict[str, float]]:
    rig = load_rig("sim")
    url = f"{rig.port}&speed=max&seed=4&heating=0&stiction=1&current_range=4&{options}"
    rig = replace(rig, port=url, program=run)
    capture = store.load(record(rig, run, folder / "run.h5", force=True))
    plate = {**capture.stated.nameplate, "rated_current_a": 1.0}
    return replace(capture, stated=replace(capture.stated, nameplate=plate)), truth(url)


def covers(p: Parameter, true: float) -> bool:
    low, high = p.interval_95
    return low <= true <= high


def named(estimate: Estimate) -> tuple[str, ...]:
    assert estimate.alternative is not None
    return estimate.alternative.terms


@pytest.mark.slow
def test_eddy_currents_are_named_and_the_inductance_of_a_meter_follows(tmp_path: Path) -> None:
    run = program(2.0, 4.0, 6.0, drive_s=0.1, coast_s=0.6)
    capture, true = measured(tmp_path, "eddy=0.5&eddy_time=2e-4", run)
    estimate = fit([capture], model="auto")
    assert named(estimate) == ("eddy",)
    found = estimate.alternative.parameters
    assert found["L2_share"].value == pytest.approx(0.5, abs=0.03)
    assert found["L"].value == pytest.approx(true["L"], rel=0.02)
    assert found["L_1kHz"].value == pytest.approx(true["L_1kHz"], rel=0.03)
    assert found["L_rated"].value == pytest.approx(found["L"].value)  # no saturation in this model
    headline = estimate.parameters["L"]
    assert headline.status == "doubtful"
    assert covers(headline, true["L"])
    assert all(covers(estimate.parameters[n], true[n]) for n in ("R", "K", "B", "J", "T0"))


@pytest.mark.study  # as a reversal does, below
def test_a_step_down_tells_load_friction(tmp_path: Path) -> None:
    capture, true = measured(tmp_path, "load_friction=0.03", program(3.0, 6.0, 2.5))
    estimate = fit([capture], model="auto")
    assert named(estimate) == ("load-friction",)
    found = estimate.alternative.parameters
    assert found["c_load"].value == pytest.approx(0.03, abs=0.005)
    assert found["J"].value == pytest.approx(true["J"], rel=0.01)
    for name in ("B", "J", "T0"):
        assert covers(estimate.parameters[name], true[name])


@pytest.mark.slow
def test_a_reversal_shows_load_friction_and_nothing_in_its_place(tmp_path: Path) -> None:
    """Friction by direction explains part of it until load friction is in."""
    run = program(3.0, 6.0, -1.5)
    capture, true = measured(tmp_path, "load_friction=0.03&quadratic=9e-11", run)
    estimate = fit([capture], model="auto")
    assert set(named(estimate)) == {"load-friction", "quadratic-load"}
    for name in ("B", "J", "T0"):
        assert covers(estimate.parameters[name], true[name])


def test_measurands_of_iron_have_their_limits() -> None:
    values = {"K": 2.0, "L": 1.0, "a_K": 0.1, "i_K": 0.0, "d_L": 0.5, "i_L": 2.0, "L2_share": 0.4}
    values["t_e"] = 1e-3
    assert measurands.torque_constant(values, 0.0) == 2.0
    assert measurands.torque_constant(values, -3.0) == pytest.approx(1.4)
    assert measurands.inductance(values) == 1.0
    assert measurands.inductance(values, 2.0) == pytest.approx(0.75)
    assert measurands.inductance(values, 0.0, 1e9) == pytest.approx(0.6)
    without = {"K": 2.0, "L": 1.0}
    assert measurands.torque_constant(without, 5.0) == 2.0
    assert measurands.inductance(without, 5.0, 1e3) == 1.0
    assert {"a_K", "i_K", "d_L", "i_L", "L2_share", "t_e"} <= set(ADDED)
