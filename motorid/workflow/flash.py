"""Puts the firmware on an Arduino by avrdude, while no capture holds its port."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from motorid.acquire.port import open_port
from motorid.acquire.ports import who_answers
from motorid.errors import DataError, LinkError, UsageError
from motorid.limits import FIRMWARE
from motorid.reading import read_file

PACKAGE = Path(__file__).resolve().parents[1]
FOLDERS = (PACKAGE / "firmware", PACKAGE.parent / "firmware" / "build" / "release")
FLASH_S = 120.0


@dataclass(frozen=True)
class Chip:
    """What avrdude must know of a board, and the bytes that its bootloader leaves.

    ``bauds``: of the bootloaders that it is sold with, in the order in which they are tried.
    ``firmware``: the board whose file it takes.
    """

    part: str
    programmer: str
    bauds: tuple[int, ...]
    flash_bytes: int
    firmware: str


CHIPS = {
    "uno": Chip("atmega328p", "arduino", (115200,), 32256, "uno"),
    "nano": Chip("atmega328p", "arduino", (57600, 115200), 30720, "uno"),  # the Uno's, pin for pin
    "mega": Chip("atmega2560", "wiring", (115200,), 253952, "mega"),
}
PICO = "pico"  # which avrdude knows nothing of: flash_drive.py


def firmware_file(board: str) -> Path:
    """The firmware that came with motorid, or that a working copy has built. Raises UsageError."""
    name = "motorid-pico.uf2" if board == PICO else f"motorid-{CHIPS[board].firmware}.hex"
    for folder in FOLDERS:
        path = folder / name
        if path.is_file():
            return path
    raise UsageError(
        f"no firmware for the board {board} is here: build it with `make -C firmware hex`, or name "
        f"the release's {name} with --hex"
    )


def check_firmware(path: Path, board: str) -> None:
    """Raises DataError unless ``path`` is Intel HEX, fits the board and is firmware made for it."""
    try:
        data = read_file(path, DataError, FIRMWARE.file, "firmware")
        image = read_hex(data.decode("ascii"))
    except ValueError as error:
        raise DataError(f"{path} is not an Intel HEX file ({error}): fetch it again") from None
    if len(image) > CHIPS[board].flash_bytes:
        raise DataError(f"{path} takes {len(image)} bytes: more than the board {board} has")
    if f"motorid-{CHIPS[board].firmware}".encode() not in image:
        raise DataError(f"{path} is not motorid's firmware for the board {board}: name another")


def read_hex(text: str) -> bytes:
    """The bytes of an Intel HEX file from its first address on, gaps as 0xFF. Raises ValueError."""
    parts: dict[int, bytes] = {}
    base = 0
    for number, line in enumerate(text.splitlines(), 1):
        record = bytes.fromhex(line[1:]) if line.startswith(":") else b""
        if len(record) < 5 or len(record) != record[0] + 5 or sum(record) & 0xFF:
            raise ValueError(f"line {number}")
        address, data = int.from_bytes(record[1:3], "big"), record[4:-1]
        match record[3]:
            case 0:
                parts[base + address] = data
            case 1:
                return _joined(parts)
            case 2:
                base = int.from_bytes(data, "big") << 4
            case 4:
                base = int.from_bytes(data, "big") << 16
    raise ValueError("its end is missing")


def _joined(parts: dict[int, bytes]) -> bytes:
    if not parts:
        raise ValueError("it is empty")
    begin, end = min(parts), max(at + len(data) for at, data in parts.items())
    if end - begin > FIRMWARE.file:
        raise ValueError("its addresses lie far apart")
    image = bytearray(b"\xff" * (end - begin))
    for at, data in parts.items():
        image[at - begin : at - begin + len(data)] = data
    return bytes(image)


def commands(port: str, board: str, hex_file: Path) -> list[list[str]]:
    """avrdude's commands, one a bootloader. Raises UsageError where ``port`` is no device."""
    if not port or "://" in port:
        raise UsageError(f"port {port}: firmware goes over a serial device, such as /dev/ttyACM0")
    chip = CHIPS[board]
    head = "avrdude", "-q", "-p", chip.part, "-c", chip.programmer
    tail = "-P", port.partition("?")[0], "-D", "-U", f"flash:w:{hex_file}:i"
    return [[*head, "-b", str(baud), *tail] for baud in chip.bauds]


def flash(port: str, board: str, hex_file: Path) -> str:
    """Flashes the board, and says who answers afterwards.

    Raises LinkError where avrdude is absent or fails, or where another program, such as a capture,
    holds the port, or nobody answers then; DataError on a bad file.
    """
    check_firmware(hex_file, board)
    lines = commands(port, board, hex_file)
    tool = shutil.which(lines[0][0])
    if tool is None:
        raise LinkError(
            "avrdude is not installed, and it is what writes firmware: install it (Debian: apt "
            "install avrdude; macOS: brew install avrdude), or see its command with --dry-run"
        )
    held = open_port(port)
    try:
        if sys.platform == "win32":  # where a port has one user at a time in any case
            held.close()
        _run_first(tool, lines, port)
    finally:
        held.close()
    return who_answers(port)


def _run_first(tool: str, lines: Sequence[Sequence[str]], port: str) -> None:
    """The first command that a bootloader answers. Raises LinkError with what the last one said."""
    for words in lines[:-1]:
        with contextlib.suppress(LinkError):
            _run([tool, *words[1:]], port)
            return
    _run([tool, *lines[-1][1:]], port)


def _run(words: Sequence[str], port: str) -> None:
    try:
        done = subprocess.run(  # noqa: S603 - no shell; the words are checked above
            words, stdin=subprocess.DEVNULL, capture_output=True, timeout=FLASH_S
        )
    except subprocess.TimeoutExpired:
        raise LinkError(
            f"{port}: avrdude did not end within {FLASH_S:g} s: unplug the board and try again"
        ) from None
    if done.returncode:
        lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
        telling = [line for line in lines if "error" in line.lower()] or lines[-1:]
        said = telling[0].strip()[:200] if telling else f"code {done.returncode}"
        raise LinkError(
            f"{port}: avrdude failed ({said}): is this the board's port, and its kind right?"
        )
