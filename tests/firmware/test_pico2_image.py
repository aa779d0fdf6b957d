"""The firmware for a Pico 2 compiles whole, and its file is what an RP2350's boot ROM takes.

No emulator of that chip is to be had, so nothing here runs it.
"""

from __future__ import annotations

import shutil
import struct
import subprocess
from pathlib import Path

import pytest

from tests.firmware.test_pico_image import PORT, blocks_of

pytestmark = pytest.mark.slow
FLASH_AT, STACK_TOP, RAM_END = 0x10000000, 0x20002000, 0x20082000
SECURE_ARM = 0xE48BFF59
LOOKED_THROUGH = 4096  # bytes of flash in which the boot ROM looks for a block
BEGIN, END = 0xFFFFDED3, 0xAB123579
IMAGE_TYPE, LAST = 0x42, 0xFF
EXECUTABLE, SECURE, ARM, OF_RP2350 = 1, 2 << 4, 0 << 8, 1 << 12
# Blocks of registers that the firmware may touch, with their aliases 16 kB, by the data sheet.
PERIPHERALS = {
    "clocks": 0x40010000, "psm": 0x40018000, "resets": 0x40020000, "io": 0x40028000,
    "pads": 0x40038000, "xosc": 0x40048000, "pll sys": 0x40050000, "pll usb": 0x40058000,
    "uart": 0x40070000, "adc": 0x400A0000, "pwm": 0x400A8000, "qmi": 0x400D0000,
    "watchdog": 0x400D8000, "rosc": 0x400E8000, "powman": 0x40100000, "ticks": 0x40108000,
    "dma": 0x50000000, "usb memory": 0x50100000, "usb": 0x50110000, "pio": 0x50200000,
}  # fmt: skip

# The port's files that reach registers, and hold no floating-point number.
DRIVING = (
    "bridge", "clocks", "encoder", "sample", "link", "reset", "flash_qmi", "usb", "usb_buffers",
    "usb_control", "usb_data",
)  # fmt: skip


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the firmware, built without a warning."""
    if not shutil.which("make") or not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("no C compiler arm-none-eabi-gcc: the Pico's firmware is not built")
    folder = tmp_path_factory.mktemp("pico2")
    words = ["make", "-s", "-C", str(PORT), "CHIP=rp2350", f"OUT={folder}"]
    done = subprocess.run(words, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def said(*command: str | Path) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="module")
def flash(built: Path) -> bytes:
    """What the file puts into flash, as another program reads it."""
    blocks = blocks_of(built / "motorid-pico2.uf2")
    assert {family for *_, family, _ in blocks} == {SECURE_ARM}
    assert [(n, of) for n, of, *_ in blocks] == [(n, len(blocks)) for n in range(len(blocks))]
    assert [at for _, _, at, *_ in blocks] == [FLASH_AT + 256 * n for n in range(len(blocks))]
    return b"".join(bytes.fromhex(payload) for *_, payload in blocks)


def test_the_file_holds_what_was_linked(built: Path, flash: bytes) -> None:
    linked = (built / "motorid-pico2.bin").read_bytes()
    assert flash[: len(linked)] == linked
    assert not any(flash[len(linked) :])


def test_an_image_definition_is_where_the_boot_rom_looks(flash: bytes) -> None:
    """A loop of one block: an image to execute, of the secure Arm cores of an RP2350."""
    words = struct.unpack(f"<{LOOKED_THROUGH // 4}I", flash[:LOOKED_THROUGH])
    first = words.index(BEGIN)
    items, at = {}, first + 1
    while words[at] & 0xFF != LAST:
        size = words[at] >> 8 & 0xFF  # in words, with its head
        items[words[at] & 0xFF] = words[at] >> 16
        at += size
    assert words[at] >> 8 & 0xFFFF == at - first - 1  # words of all items
    assert (words[at + 1], words[at + 2]) == (0, END)  # the next block is this one
    assert items == {IMAGE_TYPE: EXECUTABLE | SECURE | ARM | OF_RP2350}
    assert words.count(BEGIN) == 1


def test_the_vectors_at_the_beginning_lead_into_flash(built: Path, flash: bytes) -> None:
    stack, start = struct.unpack_from("<2I", flash)
    assert stack == STACK_TOP
    assert start & 1, "Thumb code"
    assert FLASH_AT < start < FLASH_AT + len(flash)
    lines = said("arm-none-eabi-nm", built / "motorid-pico2.elf").splitlines()
    places = {name: int(at, 16) for at, _, name in (line.split() for line in lines)}
    assert start - 1 == places["start"]
    assert stack == places["image_begin"] < places["bss_end"] <= RAM_END
    assert places["vectors"] % 512 == 0
    # the stack's end is the processor's own limit
    code = said("arm-none-eabi-objdump", "-d", "-j", ".first", built / "motorid-pico2.elf")
    assert "MSPLIM" in code


def test_it_is_for_the_processor_of_an_rp2350(built: Path) -> None:
    attributes = said("arm-none-eabi-readelf", "-A", built / "motorid-pico2.elf")
    assert "Tag_CPU_arch: v8-M.mainline" in attributes


def test_no_register_of_another_chip_is_touched(built: Path) -> None:
    """Every address of a peripheral in the port's code is one that an RP2350 has."""
    objects = [built / f"{name}.o" for name in DRIVING]
    lines = "".join(said("arm-none-eabi-objdump", "-d", path) for path in objects).splitlines()
    words = {int(line.split(".word")[1].split()[0], 16) for line in lines if ".word" in line}
    registers = {word for word in words if 0x40000000 <= word < 0x50300000}
    for word in registers:
        block = next((at for at in PERIPHERALS.values() if 0 <= word - at < 0x4000), None)
        assert block is not None, f"{word:#x}"
    assert len(registers) >= len(PERIPHERALS)
