"""A release's firmware is the same to the byte wherever it is built, and is what the boards run."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

import pytest

from motorid.workflow import flash, flash_drive
from tests.conformance.boards import FIRMWARE, built_in_place
from tests.load.pty import ROOT

pytestmark = [pytest.mark.slow, pytest.mark.long]

BUILT = ("motorid-uno.hex", "motorid-mega.hex", "motorid-pico.uf2")
TOOLS = ("make", "avr-gcc", "arm-none-eabi-gcc")


def build(folder: Path) -> Path:
    """A copy of the firmware's source in ``folder``, built there; the folder of what came of it."""
    source = folder / "firmware"
    shutil.copytree(
        ROOT / "firmware", source, ignore=shutil.ignore_patterns("build", "__pycache__")
    )
    done = subprocess.run(["make", "-s", "-C", str(source), "hex"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return source / "build" / "release"


@pytest.fixture(scope="module")
def builds(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two, from folders whose names differ in length: this checkout's own, and a copy."""
    for tool in TOOLS:
        if not shutil.which(tool):
            pytest.skip(f"no C compiler {tool}: the boards' firmware is not built")
    parts = ("release", "uno", "mega", "pico")
    first = built_in_place("hex", *parts, folder=tmp_path_factory.mktemp("here")) / "release"
    return first, build(tmp_path_factory.mktemp("somewhere else quite Ω".replace(" ", "_")))


def test_two_builds_are_one(builds: tuple[Path, Path]) -> None:
    first, second = builds
    assert sorted(path.name for path in first.iterdir()) == ["SHA256SUMS", *sorted(BUILT)]
    for path in first.iterdir():
        assert path.read_bytes() == (second / path.name).read_bytes()
    for line in (first / "SHA256SUMS").read_text().splitlines():
        digest, name = line.split()
        assert hashlib.sha256((first / name).read_bytes()).hexdigest() == digest


def test_the_file_is_the_firmware_that_the_emulated_board_runs(builds: tuple[Path, Path]) -> None:
    for board in ("uno", "mega"):
        path = builds[0] / f"motorid-{board}.hex"
        flash.check_firmware(path, board)
        image = flash.read_hex(path.read_text())
        elf = builds[0].parent / board / f"motorid-{board}.elf"
        binary = elf.with_suffix(".bin")
        copy = ("avr-objcopy", "-O", "binary", "-R", ".eeprom", str(elf), str(binary))
        subprocess.run(copy, check=True)
        assert image == binary.read_bytes()


def test_the_picos_file_holds_what_its_linker_made(builds: tuple[Path, Path]) -> None:
    data = flash_drive.check_firmware(builds[0] / "motorid-pico.uf2")
    linked = (builds[0].parent / "pico" / "motorid-pico.bin").read_bytes()
    # between them stands the CRC of the second boot stage
    assert flash_drive.read_uf2(data)[256 : len(linked)] == linked[256:]


def test_no_path_is_in_the_file(builds: tuple[Path, Path]) -> None:
    for name in BUILT:
        data = (builds[1] / name).read_bytes()
        read = flash_drive.read_uf2(data) if name.endswith("uf2") else flash.read_hex(data.decode())
        for place in (FIRMWARE, builds[1].parents[2]):
            assert str(place).encode() not in read
