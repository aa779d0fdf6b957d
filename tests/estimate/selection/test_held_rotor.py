"""Captures of a rotor that is held: R, L and the iron's part of L, from the simulated board."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from motorid.acquire import record
from motorid.capture import store
from motorid.capture.model import POSITION, Capture
from motorid.errors import DataError, UsageError
from motorid.estimate.selection.held_rotor import SHOWN
from motorid.excitation import Levels, prbs
from motorid.program import Program, Rotor, Step, StepKind
from motorid.rig_file import parse
from motorid.sim.motor import find_motor
from tests.six_parameters import fit

MOTOR = find_motor("maxon-re35")[1]
RIG = f"""
port = "sim://?motor=maxon-re35&clamped=1&speed=max&heating=0&ambient=25"
[wiring]
counts_per_turn = 2048
bridge_resistance_ohm = 0.04
bridge_resistance_uncertainty_ohm = 0.004
supply_voltage_v = {MOTOR.supply_v}
[limits]
current_a = 30
speed_rad_s = 1000
supply_min_v = 20
supply_max_v = 40
[nameplate]
voltage_v = 30
resistance_ohm = {MOTOR.resistance_ohm}
rated_current_a = 5
[sampling]
rate_hz = 10000
"""
SMALL, LARGE = (Levels(StepKind.DRIVE_DUTY, 0.0, amplitude) for amplitude in (0.2, 0.8))
PROGRAM = Program(
    (Step(StepKind.COAST, 0.005), *prbs(SMALL, 3, 0.022), *prbs(LARGE, 3, 0.025)),
    Rotor.CLAMPED,
    30.0,
)
L = MOTOR.inductance_h


@cache
def captured(options: str) -> Capture:
    rig = parse(RIG)
    rig = replace(rig, port=f"{rig.port}&{options}", program=PROGRAM)
    with TemporaryDirectory() as folder:
        return store.load(record.capture(rig, rig.program, Path(folder) / "run.h5"))


def iron(seed: int, saturation: float = 0.5, eddy: float = 0.5, time_s: float = 530e-6) -> str:
    return f"seed={seed}&saturation={saturation}&eddy={eddy}&eddy_time={time_s}"


def of_meter(eddy: float, time_s: float, hz: float = 1000.0) -> float:
    """L at a frequency, of L1 and L2 beside R_c."""
    impedance = 2j * pi * hz * L * (1 - eddy + eddy / (1 + 2j * pi * hz * time_s))
    return impedance.imag / (2 * pi * hz)


@pytest.mark.slow
@pytest.mark.parametrize("time_s", [pytest.param(530e-6, marks=pytest.mark.study), 300e-6, 100e-6])
def test_saturation_and_eddies_are_told_apart(time_s: float) -> None:
    found = fit([captured(iron(1, time_s=time_s))], model="auto").alternative
    assert found is not None
    assert found.terms == ("eddy", "saturation")
    truths = {
        "R": MOTOR.resistance_ohm,
        "L": L,
        "L_1kHz": of_meter(0.5, time_s),
        "L_rated": L * (1 - 0.625 * 25 / (25 + 12.5**2)),
        "L2_share": 0.5,
        "t_e": time_s,
        "d_L": 0.625,  # half of L at the stall current, half of all loss at half of that
        "i_L": 12.5,
    }
    for name, true in truths.items():
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low < true < high, name
    assert found.parameters["L"].value == pytest.approx(L, rel=0.02)
    assert found.parameters["L_1kHz"].value == pytest.approx(truths["L_1kHz"], rel=0.03)
    assert found.parameters["K"].value is None
    assert "K_rated" not in found.parameters


@pytest.mark.slow
def test_the_plain_value_of_l_is_doubtful_then() -> None:
    found = fit([captured(iron(1))], model="auto")
    assert found.parameters["L"].status == "doubtful"
    for name, true in (("R", MOTOR.resistance_ohm), ("L", L)):
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low < true < high
    assert found.diagnostics[0].code == "better_model"
    assert not any(one.code == "saturation" for one in found.suspects)


@pytest.mark.slow
def test_a_motor_without_iron_gets_no_such_term() -> None:
    found = fit([captured("seed=2")], model="auto")
    assert found.alternative is None
    for name, true in (("R", MOTOR.resistance_ohm), ("L", L)):
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low < true < high
    assert {found.parameters[n].status for n in ("K", "B", "J", "T0")} == {"not_identifiable"}


@pytest.mark.slow
def test_one_effect_alone_is_named_alone() -> None:
    for options, name in ((iron(3, eddy=0.0), "saturation"), (iron(3, saturation=0.0), "eddy")):
        found = fit([captured(options)], model="auto").alternative
        assert found is not None
        assert found.terms == (name,)


@pytest.mark.slow
def test_a_term_that_needs_motion_is_refused() -> None:
    known = ", ".join(term.name for term in SHOWN)
    with pytest.raises(UsageError, match=f"--model cogging: a rotor .* it shows {known}"):
        fit([captured("seed=2")], model="cogging")


def test_held_and_free_are_not_fitted_together() -> None:
    capture = captured("seed=2")
    free = replace(capture, program=replace(PROGRAM, rotor=Rotor.FREE, energy_j=None))
    with pytest.raises(DataError, match="fit them apart"):
        fit([capture, free])


def moved(counts: int) -> Capture:
    capture = captured("seed=2")
    channel = capture.channels[POSITION]
    raw = channel.raw + np.where(np.arange(len(capture)) > 100, counts, 0)
    return replace(capture, channels={**capture.channels, POSITION: replace(channel, raw=raw)})


@pytest.mark.slow
def test_a_clamp_that_gives_way_is_said_and_one_that_opens_is_refused() -> None:
    said = {one.code for one in fit([moved(3)], model="six").diagnostics}
    assert "clamp_gave_way" in said
    with pytest.raises(DataError, match=r"the rotor is held, and it moved by 9\.1°: clamp it"):
        fit([moved(52)])
