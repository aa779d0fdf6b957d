"""What the board says after a crash, behind the bootloaders that boards are sold with."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import pytest

from motorid.wire.enums import ResetCause
from tests.conformance.boards import emulator_lacks
from tests.emulated import crashes
from tests.emulated.bootloaders import hex_file, lacking
from tests.emulated.crashes import Board, Crash

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def _needs_both() -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated board: {lack}")
    if lack := lacking():
        pytest.skip(lack)


@pytest.mark.parametrize("running", [True, pytest.param(False, marks=pytest.mark.study)])
def test_the_page_says_what_the_boards_say(running: bool) -> None:
    head, rule, *lines = crashes.told().splitlines()
    assert [head, rule] == crashes.table_head()
    assert {line.split(" | ")[1] for line in lines} == set(crashes.WHEN.values())
    of_these = [line for line in lines if line.split(" | ")[1] == crashes.WHEN[running]]
    assert list(crashes.rows([running])) == of_these


def test_no_power_on_looks_like_a_hang(tmp_path: Path) -> None:
    """Whatever memory holds, and with what a watchdog's MCUSR would be in r2."""
    with ExitStack() as stack:
        board = Board("uno", hex_file("uno", tmp_path), stack)
        for seed in range(20):
            told = board.crash(Crash("", "power", seed), running=seed % 2 == 0, left_in_r2=0x08)
            assert told == (ResetCause.POWER_ON, False)


def test_a_slow_main_loop_is_no_hang(tmp_path: Path) -> None:
    """After the watchdog's first bite the loop goes on: the next reset is not the watchdog's.

    Whose it was the bootloader has cleared away.
    """
    with ExitStack() as stack:
        board = Board("uno", hex_file("uno", tmp_path), stack)
        board.emulator.set("stall", 1)
        board.client.wait(0.2)  # of 0.25
        board.emulator.set("unstall", 1)
        board.client.wait(0.3)
        assert board.emulator.facts()["resets"] == 0
        told = board.crash(Crash("", "reset", 2), running=False, left_in_r2=0x08)
        assert told == (ResetCause.UNKNOWN, False)
