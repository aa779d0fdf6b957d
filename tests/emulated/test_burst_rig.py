"""The rig file that shows a fast burst runs as it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.capture import store
from motorid.sim.motor import find_motor
from motorid.workflow.record import bench, bursting, capture_runs
from tests.conformance.boards import ROOT, emulator_lacks

pytestmark = pytest.mark.slow


def test_the_rig_for_bursts_captures_one(tmp_path: Path) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated uno: {lack}")
    rig = bursting(bench(str(ROOT / "rigs" / "emulated-uno-burst.toml")))
    (path,) = capture_runs(rig, tmp_path / "burst.h5")
    capture = store.load(path)
    assert capture.end_reason == "completed"
    assert capture.period_s == pytest.approx(1 / 16_000, rel=0.01)
    assert len(capture) == 76
    # two milliseconds at full duty, of a motor that settles within 0.07: nearly the stall current
    motor = find_motor("faulhaber-2338s006s")[1]
    stall = motor.supply_v / motor.resistance_ohm
    assert 0.8 * stall < capture.channels["current"].values.max() < stall
