"""The core in C: its tests, its sizes on an 8-bit board, and lint, by ``make -C firmware``."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conformance.boards import building

FIRMWARE = Path(__file__).resolve().parents[2] / "firmware"
NEEDS = {
    "gcc": "no make and gcc",
    "avr-gcc": "no C compiler avr-gcc",
    "clang": "no clang",
    "cppcheck": "no cppcheck",
}
FUZZ_SECONDS = os.environ.get("FUZZ_SECONDS", "2")  # a minute by `make fuzz`


def make(target: str, tool: str, *more: str, also: str = "") -> str:
    """What a target prints, if asked ``also`` on standard error. Skips without its tool."""
    if sys.platform == "win32" or not shutil.which("make") or not shutil.which("gcc"):
        pytest.skip("no make and gcc: the firmware's host port is not built")
    if not shutil.which(tool):
        pytest.skip(f"{NEEDS[tool]}: make {target} needs it")
    command = ["make", "-s", "-C", str(FIRMWARE), f"PYTHON={sys.executable}", target, *more]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + (done.stderr if also == "stderr" else "")


@pytest.mark.slow
@pytest.mark.long
def test_the_core_passes_its_tests_under_sanitizers(tmp_path: Path) -> None:
    lines = make("check", "gcc", f"BUILD={tmp_path}").splitlines()
    *tests, replay = lines
    assert int(replay.removesuffix(" inputs replayed")) > 100
    assert len(tests) == 2  # with the sizes of a small board, and of this computer
    for line in tests:
        count, _, rest = line.partition(" ")
        assert int(count) >= 40
        assert rest == "tests, 0 failed"


@pytest.mark.slow
def test_the_core_fits_its_budget(tmp_path: Path) -> None:
    lines = make("sizes", "avr-gcc", f"BUILD={tmp_path}").splitlines()
    assert [line.split("  ")[0] for line in lines] == [
        "flash",
        "RAM",
        "stack of core_sample",
        "stack of core_poll",
    ]


@pytest.mark.slow
def test_a_second_compiler_builds_the_boards_firmware(tmp_path: Path) -> None:
    """By clang, without a warning, within flash and RAM; tests/conformance runs what it builds."""
    if not shutil.which("avr-gcc"):
        pytest.skip(f"{NEEDS['avr-gcc']}: make second takes its headers, and links by it")
    lines = make("second", "clang", f"BUILD={tmp_path}").splitlines()
    assert [line.split(":")[0] for line in lines] == ["uno", "mega"]
    for board in ("uno", "mega"):
        folder = tmp_path / f"{board}-clang"
        assert (folder / f"motorid-{board}.elf").read_bytes()[18] == 83  # e_machine: AVR
        assert b"GCC" not in (folder / "main.o").read_bytes()


@pytest.mark.slow
def test_lint_is_quiet() -> None:
    assert make("lint", "cppcheck") == ""


@pytest.mark.slow
@pytest.mark.long
def test_a_fuzzer_finds_nothing_in_the_receiver(tmp_path: Path) -> None:
    said = make("fuzz", "clang", f"BUILD={tmp_path}", f"FUZZ_SECONDS={FUZZ_SECONDS}", also="stderr")
    runs = re.search(r"number_of_executed_units: (\d+)", said)
    assert runs
    assert int(runs[1]) > 2000  # far more where the computer is not busy


@pytest.mark.slow
def test_the_deepest_stack_of_the_ports_is_bounded_by_their_calls() -> None:
    """``check`` of the AVR port holds the bound; the emulator has seen 278 bytes of it."""
    port = str(FIRMWARE / "ports" / "avr")
    with building():  # what the release's files are made of
        said = make("all", "avr-gcc", "-C", port, "BOARD=uno")
    found = re.search(r"stack: at most (\d+) of (\d+) bytes", said)
    assert found
    bound, room = map(int, found.groups())
    assert 278 <= bound <= room
    command = [
        sys.executable,
        str(FIRMWARE / "test" / "stack.py"),
        str(FIRMWARE / "build" / "uno" / "motorid-uno.elf"),
    ]
    short = subprocess.run([*command, str(2048 - room + bound - 1)], capture_output=True, text=True)
    assert short.returncode != 0
    assert "the stack may reach the data" in short.stderr
