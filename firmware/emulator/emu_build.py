"""An emulated board's firmware and emulator, built when they are not up to date."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from motorid.errors import RigError

ROOM = Path(__file__).parent
FIRMWARE = ROOM.parent
BUILD = FIRMWARE / "build"
PICO = "pico"


def missing_for_pico() -> str:
    """What an emulated Pico lacks here, or nothing."""
    compiler = ("arm-none-eabi-gcc", "gcc-arm-none-eabi and libnewlib-arm-none-eabi")
    for tool, package in (compiler, ("gcc", "gcc"), ("make", "make"), ("node", "nodejs")):
        if shutil.which(tool) is None:
            return f"{tool} is not installed (Debian: {package})"
    if not (ROOM / "pico" / "node_modules" / "rp2040js").is_dir():
        return "rp2040js is not installed (npm ci --prefix firmware/emulator/pico)"
    return ""


def missing(compiler: str = "gcc") -> str:
    """What a board emulated with that compiler's firmware lacks here, or nothing."""
    second = (("clang", "clang"),) if compiler == "clang" else ()
    always = (("avr-gcc", "gcc-avr and avr-libc"), ("gcc", "gcc"), ("make", "make"))
    for tool, package in (*always, *second):
        if shutil.which(tool) is None:
            return f"{tool} is not installed (Debian: {package})"
    if not any(
        Path(p, "simavr/sim_avr.h").exists() for p in ("/usr/include", "/usr/local/include")
    ):
        return "libsimavr is not installed (Debian: libsimavr-dev and libelf-dev)"
    return ""


def build(board: str, compiler: str, defines: str) -> tuple[Path, Path]:
    """Emulator and image, built when they are not up to date. Raises RigError.

    Whether they are is asked once in a process: make takes longer to see it than a board to start.
    """
    if lack := missing_for_pico() if board == PICO else missing(compiler):
        raise RigError(f"emu://: {lack}")
    return _built(board, compiler, defines.strip())


@cache
def _built(board: str, compiler: str, defines: str) -> tuple[Path, Path]:
    with _alone():
        return _build(board, compiler, defines)


@contextlib.contextmanager
def _alone() -> Iterator[None]:
    """One process builds at a time: two would write the same objects."""
    import fcntl  # where libsimavr is, this is too

    BUILD.mkdir(exist_ok=True)
    with (BUILD / "lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _build(board: str, compiler: str, defines: str) -> tuple[Path, Path]:
    tag = "".join(c if c.isalnum() or c in "._" else "-" for c in defines.replace("-D", ""))
    if board == PICO:
        folder = BUILD / f"emu-pico-{tag}".rstrip("-")
        _make(ROOM, "pico", f"OUT={BUILD / 'emulator'}")
        python = f"PYTHON={sys.executable}"
        _make(FIRMWARE / "ports" / "rp2040", f"OUT={folder}", f"ANALOG={defines}", python)
        return BUILD / "emulator" / "pico_rig", folder / "motorid-pico.uf2"
    _make(ROOM, f"OUT={BUILD / 'emulator'}")
    second = "" if compiler == "gcc" else f"-{compiler}"
    folder = BUILD / f"emu-{board}{second}-{tag.strip('-')}"
    choice = f"BOARD={board}", f"COMPILER={compiler}"
    _make(FIRMWARE / "ports" / "avr", *choice, f"OUT={folder}", f"SHIELD={defines}")
    return BUILD / "emulator" / "emulator", folder / f"motorid-{board}.elf"


def _make(folder: Path, *arguments: str) -> None:
    done = subprocess.run(
        ["make", "-s", "-C", str(folder), *arguments], capture_output=True, text=True, check=False
    )
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["make failed"]
        why = next((line for line in lines if "error" in line), lines[0])
        raise RigError(f"emu://: building {folder.name} failed: {why[:200]}")
