"""One motor through each board's firmware: as true as promised, and as the simulated board says."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conformance.boards import emulator_lacks
from tests.emulated.motors import MOST, MOTORS, NAMES, identify

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("board", "motor"), [("uno", MOTORS[0]), ("mega", MOTORS[1])])
def test_a_motor_is_identified_through_the_firmware(board: str, motor: str, tmp_path: Path) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated {board}: {lack}")
    found = identify(tmp_path, board, motor)
    simulated = identify(tmp_path, "sim", motor)
    for name in NAMES:
        here, there = found[name], simulated[name]
        assert abs(here.error) <= MOST[name], f"{name} is off by {here.error:.2%}"
        # 3 standard uncertainties: twelve figures, each run's errors drawn by its seed
        assert abs(here.value - here.truth) <= 1.5 * here.half, name
        apart = 1.5 * (here.half**2 + there.half**2) ** 0.5
        assert abs(here.value - there.value) <= apart, f"{name} differs from the simulated board's"
