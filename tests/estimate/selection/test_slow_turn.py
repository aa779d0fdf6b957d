"""A slow turn both ways shows cogging well below the Coulomb torque."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import record
from motorid.capture import store
from motorid.rig_file import parse
from motorid.sim.motor import find_motor
from tests.six_parameters import fit

COGGING = 1e-3  # N·m, a third of the Coulomb torque
MOTOR = find_motor("maxon-re35")[1]
RIG = f"""
port = "sim://?motor=maxon-re35&speed=max&cogging={COGGING}&seed=2"
[wiring]
counts_per_turn = 2048
bridge_resistance_ohm = 0.04
supply_voltage_v = 34
brush_drop_v = 0.0
[limits]
current_a = 33
speed_rad_s = 1000
supply_min_v = 20
supply_max_v = 40
[nameplate]
voltage_v = 30.0
resistance_ohm = 1.2
inductance_h = 340e-6
torque_constant_nm_a = 38.9e-3
inertia_kg_m2 = 68.1e-7
no_load_current_a = 0.123
[sampling]
rate_hz = 5000
[[program.steps]]
kind = "coast"
duration_s = 0.02
[[program.steps]]
kind = "slow_turn"
volts = 0.7
[[program.steps]]
kind = "drive_volts"
volts = 15
duration_s = 0.15
[[program.steps]]
kind = "coast"
duration_s = 1.5
"""


@pytest.mark.slow
def test_the_cogging_of_a_slow_turn_is_found(tmp_path: Path) -> None:
    rig = parse(RIG)
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    turns = capture.channels["position"].values / (2 * np.pi)
    ways = {}
    for index in (1, 3):
        first, after = (capture.phases[k].tick for k in (index, index + 1))
        here = turns[(capture.ticks >= first) & (capture.ticks < after)]
        ways[index] = here[-1] - here[0]
    assert ways[1] > 1.5
    assert ways[3] < -1.5
    found = fit([capture], model="auto").alternative
    assert found is not None
    assert "cogging" in found.terms
    assert found.parameters["N_c"].value == MOTOR.ripple_per_turn
    assert found.parameters["T_c"].value == pytest.approx(COGGING, rel=0.05)
