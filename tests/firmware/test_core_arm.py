"""The core compiles for the processors of a Pico and a Pico 2, without a warning."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

FIRMWARE = Path(__file__).resolve().parents[2] / "firmware"
PROCESSORS = ("cortex-m0plus", "cortex-m33")
FLASH = 16 * 1024  # bytes of code and constants that the core may take, of 2 MB
BLOCKS = 17982  # bytes of samples in firmware/Makefile
RAM = 4 * 1024  # bytes beside those

#: What the core may ask of a bare board: its port and a C library without heap or system.
OURS = {"port"}
MEMORY = {"memcpy", "memset", "memmove"}
FLOATS = {"ceilf", "fabsf", "floorf", "fmaxf", "fminf", "lroundf", "sqrtf"}
#: What the compiler's own library has for a processor without the instruction.
HELPERS = ("__aeabi_", "__clzsi2", "__gnu_thumb1_case_")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the core's objects, one a processor."""
    if not shutil.which("make") or not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("no C compiler arm-none-eabi-gcc: the core is not built for 32-bit boards")
    folder = tmp_path_factory.mktemp("arm")
    done = subprocess.run(
        ["make", "-s", "-C", str(FIRMWARE), "arm", f"BUILD={folder}"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return folder / "arm"


def _said(*command: str) -> list[str]:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.mark.slow
@pytest.mark.parametrize("processor", PROCESSORS)
def test_size(built: Path, processor: str) -> None:
    """It fits: code, and RAM without the blocks of samples."""
    sizes = _said("arm-none-eabi-size", str(built / f"core_{processor}.o"))[1].split()
    text, data, bss = map(int, sizes[:3])
    assert 0 < text + data <= FLASH
    assert BLOCKS <= data + bss <= BLOCKS + RAM


@pytest.mark.slow
@pytest.mark.parametrize("processor", PROCESSORS)
def test_needs(built: Path, processor: str) -> None:
    """No heap, no system, and no atomics by a library: there the port must lock."""
    lines = _said("arm-none-eabi-nm", "-u", str(built / f"core_{processor}.o"))
    needed = {line.split()[-1] for line in lines}
    assert needed >= OURS
    assert {n for n in needed - OURS - MEMORY - FLOATS if not n.startswith(HELPERS)} == set()
