"""The real firmware with each kind of driver: the fit finds the motor behind it."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid import fit
from motorid.acquire import record
from motorid.capture import store
from motorid.workflow.kit import Answers, kit
from tests.conformance.boards import emulator_lacks
from tests.emulated.motors import shortened

MOTOR = "dunkermotoren-gr42"
BENCH = f"emu://uno?motor={MOTOR}&heating=no&ambient=25&counts_per_turn=44"
DRIVERS = {
    "l298n": "driver=bipolar&bridge_drop=1.4&bridge_resistance=1.15",
    "in-in": "driver=in_in&defines=-DSHIELD_BRIDGE=WIRE_BRIDGE_IN_IN",
    "pwm-dir": "driver=pwm_dir&defines=-DSHIELD_BRIDGE=WIRE_BRIDGE_PWM_DIR",
}
TRUE = {"R": 5.95, "L": 8.9e-3, "K": 0.0514, "J": 7.1e-6}


@pytest.mark.slow
@pytest.mark.parametrize("driver", DRIVERS)
def test_the_motor_is_found_behind_every_driver(driver: str, tmp_path: Path) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    url = f"{BENCH}&gain_error=0&voltage_gain_error=0&{DRIVERS[driver]}"
    said = Answers(
        "uno", url, driver, "ina240-10mohm", 44, 27.0, MOTOR, 24.0,
        resistance_ohm=5.95, no_load_rpm=3600, most_a=2.0, ambient_c=25.0,
    )  # fmt: skip
    rig = kit(said, "kit", "").rig
    capture = store.load(record.capture(rig, shortened(rig.program, 1 / 3), tmp_path / "run.h5"))
    found = fit(capture, model="six")
    for name, true in TRUE.items():
        low, high = found.parameters[name].interval_95 or (0.0, 0.0)
        assert low <= true <= high, name
