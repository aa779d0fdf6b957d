"""The bootloaders that boards are sold with, from Debian's package of Arduino's cores.

They are GPL-2: they run beside the firmware here and are never part of this repository.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

PACKAGE = Path("/usr/share/arduino/hardware/arduino/avr/bootloaders")
NAMES = {"uno": "Optiboot 4.4", "mega": "stk500v2"}
# As the package's Makefile has it, but for the flashes of the light: with them Debian's compiler
# makes 532 bytes of it, and the boot section has 512.
OPTIMISE = ("-Os", "-fno-inline-small-functions", "-fno-split-wide-types", "-mshort-calls")
CHIP = ("-mmcu=atmega328p", "-DF_CPU=16000000L", "-DBAUD_RATE=115200", "-DLED_START_FLASHES=0")
PLACES = ("-Wl,--section-start=.text=0x7e00", "-Wl,--section-start=.version=0x7ffe", "-Wl,--relax")
SECTIONS = ("-j", ".text", "-j", ".data", "-j", ".version")


def lacking() -> str:
    """What keeps them from running here, or nothing."""
    return "" if PACKAGE.is_dir() else "no arduino-core-avr: `apt-get install arduino-core-avr`"


def hex_file(board: str, folder: Path) -> Path:
    """The file to put before the firmware; what must be built comes into ``folder``."""
    if board == "mega":
        return PACKAGE / "stk500v2" / "stk500boot_v2_mega2560.hex"
    elf, made = folder / "optiboot.elf", folder / "optiboot.hex"
    source = PACKAGE / "optiboot" / "optiboot.c"
    _run("avr-gcc", "-w", *OPTIMISE, *CHIP, *PLACES, "-nostartfiles", "-nostdlib",
         "-o", str(elf), str(source))  # fmt: skip
    _run("avr-objcopy", *SECTIONS, "--set-section-flags", ".version=alloc,load", "-O", "ihex",
         str(elf), str(made))  # fmt: skip
    return made


def _run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True)
