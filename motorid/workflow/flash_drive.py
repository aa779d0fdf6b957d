"""Puts the firmware on a Raspberry Pi Pico: a UF2 file, copied to the drive of its boot ROM.

UF2 as microsoft/uf2 describes it; the drive as the RP2040 data sheet, 2.8.4.
"""

from __future__ import annotations

import os
import string
import struct
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from motorid.acquire.ports import who_answers
from motorid.errors import DataError, LinkError, UsageError
from motorid.limits import FIRMWARE
from motorid.reading import read_file
from motorid.visible import on_one_line

BLOCK_BYTES = 512
HEAD = struct.Struct("<8I")
MAGIC_START, MAGIC_SECOND, MAGIC_END = 0x0A324655, 0x9E5D5157, 0x0AB16F30
HAS_FAMILY = 0x2000
FAMILY_RP2040 = 0xE48BFF56
MOST_PAYLOAD = 476
FLASH_AT, FLASH_BYTES = 0x10000000, 2 << 20
FIRMWARE_NAME = b"motorid-pico"
INFO_FILE = "INFO_UF2.TXT"
BOARD_ID = "Board-ID: RPI-RP2"
INFO_BYTES = 4096
RESTARTS_S, POLL_S = 10.0, 0.5
HOLD = (
    "hold its button BOOTSEL while you connect its USB, and let it go: it then shows as a drive "
    "named RPI-RP2"
)


def check_firmware(path: Path) -> bytes:
    """The bytes of ``path``. Raises DataError unless it is motorid's UF2 file for a Pico."""
    data = read_file(path, DataError, FIRMWARE.file, "firmware")
    try:
        image = read_uf2(data)
    except ValueError as error:
        raise DataError(
            f"{on_one_line(str(path))} is not a UF2 file for a Pico ({error}): fetch it again"
        ) from None
    if FIRMWARE_NAME not in image:
        raise DataError(
            f"{on_one_line(str(path))} is not motorid's firmware for the board pico: name another"
        )
    return data


def read_uf2(data: bytes) -> bytes:
    """Flash from its beginning, as the blocks fill it. Raises ValueError."""
    count, rest = divmod(len(data), BLOCK_BYTES)
    if rest or not count:
        raise ValueError("it is no whole number of blocks of 512 bytes")
    blocks = (data[at : at + BLOCK_BYTES] for at in range(0, len(data), BLOCK_BYTES))
    return b"".join(_payload(block, number, count) for number, block in enumerate(blocks))


def _payload(block: bytes, number: int, count: int) -> bytes:
    first, second, flags, address, size, at, blocks, family = HEAD.unpack_from(block)
    (last,) = struct.unpack_from("<I", block, BLOCK_BYTES - 4)
    if (first, second, last) != (MAGIC_START, MAGIC_SECOND, MAGIC_END):
        raise ValueError(f"block {number} is none")
    if not flags & HAS_FAMILY or family != FAMILY_RP2040:
        raise ValueError("it is for another processor")
    if (at, blocks) != (number, count):
        raise ValueError(f"block {number} of {count} is missing")
    if size > MOST_PAYLOAD or address != FLASH_AT + number * size:
        raise ValueError(f"block {number} does not follow the one before")
    if (number + 1) * size > FLASH_BYTES:
        raise ValueError("it takes more than the board has")
    return block[HEAD.size : HEAD.size + size]


# ---------------------------------------------------------------- the drive


def is_drive(folder: Path) -> bool:
    """Whether ``folder`` is a Pico's boot drive, by the file that its boot ROM shows there."""
    try:
        with open(folder / INFO_FILE, encoding="ascii", errors="replace") as file:
            return BOARD_ID in file.read(INFO_BYTES)
    except OSError:
        return False


def find_drive(mounted: Iterator[Path] | None = None) -> Path:
    """The only boot drive that is mounted here.

    Raises LinkError where there is none, UsageError where there are several.
    """
    found = [folder for folder in mounted or _mounted() if is_drive(folder)]
    if not found:
        raise LinkError(
            f"no Pico waits for firmware: {HOLD} (or name the folder where it is with --drive)"
        )
    if len(found) > 1:
        names = " and ".join(map(str, found))
        raise UsageError(f"{len(found)} Picos wait for firmware, at {names}: name one with --drive")
    return found[0]


def _mounted() -> Iterator[Path]:
    """Where this system shows drives."""
    if sys.platform == "win32":
        yield from (Path(f"{letter}:\\") for letter in string.ascii_uppercase[2:])
    elif sys.platform == "darwin":
        yield from Path("/Volumes").glob("*")
    else:
        yield from _linux_mounts(Path("/proc/self/mounts"))


def _linux_mounts(table: Path) -> Iterator[Path]:
    """Of vfat; the table writes a blank as \\040 (``man 5 fstab``)."""
    try:
        lines = table.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return
    for fields in (line.split(" ") for line in lines):
        if len(fields) > 2 and fields[2] == "vfat":
            yield Path(fields[1].replace("\\040", " "))


# ---------------------------------------------------------------- flashing


def target(path: Path, drive: Path | None) -> Path:
    """The file to write on ``drive``, or on the only one there is.

    Raises LinkError or UsageError where there is no such drive.
    """
    folder = drive or find_drive()
    if not is_drive(folder):
        raise UsageError(f"{on_one_line(str(folder))} is not a Pico's boot drive: {HOLD}")
    return folder / path.name


def await_board(port: str) -> str:
    """Who answers on the port, which appears some time after the board has restarted.

    Raises LinkError where nobody does.
    """
    until = time.monotonic() + RESTARTS_S
    while True:
        try:
            return who_answers(port)
        except LinkError:
            if time.monotonic() >= until:
                raise
        time.sleep(POLL_S)


def flash(path: Path, drive: Path | None) -> Path:
    """Copies the firmware; the board restarts by itself as soon as it has all blocks. The drive.

    Raises DataError on a bad file, LinkError or UsageError where no drive takes it.
    """
    data = check_firmware(path)
    file = target(path, drive)
    written = 0
    try:
        with open(file, "wb", buffering=0) as out:
            while written < len(data):
                written += out.write(data[written:])
            os.fsync(out.fileno())
    except OSError as error:
        # With its last block the drive goes, before the file is closed.
        if written < len(data) or is_drive(file.parent):
            raise LinkError(
                f"{on_one_line(str(file))}: cannot be written: {error.strerror or error}"
            ) from None
    return file.parent
