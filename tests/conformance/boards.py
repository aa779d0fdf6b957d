"""The boards that the suite knows, each behind the same few functions."""

from __future__ import annotations

import contextlib
import importlib.util
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import pytest

from motorid.acquire.port import Port, open_port
from motorid.sim.port import SimPort, open_sim
from motorid.wire.enums import Fault, ResetCause
from tests.conformance.lock_step import LockStepPort, connect
from tests.conformance.pico_pool import POOL

ROOT = Path(__file__).resolve().parents[2]
FIRMWARE = ROOT / "firmware"
HOST_PORT = FIRMWARE / "ports" / "host"
FACTS_AT, SLOT_BYTES = 64, 67  # in an AVR board's EEPROM: firmware/ports/avr/memory.c
JOURNAL_AT = 0x1FE000  # in a Pico's flash: firmware/ports/rp2040/journal.c


class Board(Protocol):
    """A board under test, freshly started, with its motor at rest.

    ``traits`` says what can be done to it: "fresh" (every test has its own, so that hello is
    seen), "exact" (time moves only in ``read``), "bridge" (``is_open`` knows), "reset", "driver"
    (its driver's fault output), "inputs" (contacts), "memory" (it can be damaged), "own" (it drives
    with its firmware's facts while none are stored), "blank" (it may come without any) and "break"
    (any fault of its own).
    """

    name: str
    port: Port
    traits: frozenset[str]

    def is_open(self) -> bool:
        """True while no switch of the bridge conducts."""

    def reset(self, cause: int) -> None:
        """Restart its processor."""

    def break_(self, fault: int, value: int) -> None:
        """Let it notice a fault of its own at the next sample."""

    def complain(self, on: bool) -> None:
        """Let the bridge's driver report a fault, or no more."""

    def close_inputs(self, mask: int) -> None:
        """Bit n: the contact of input n is closed from now on."""

    def spoil(self) -> None:
        """Damage the memory that keeps the facts of its front end."""

    def close(self) -> None:
        """Done with it."""


def query(options: dict[str, Any]) -> str:
    """Options as a sim:// URL at full speed."""
    return "sim://?" + "&".join(f"{k}={v}" for k, v in {"speed": "max", **options}.items())


class SimulatedBoard:
    """The simulated board of sim://."""

    name = "sim"
    traits = frozenset({"fresh", "exact", "bridge", "reset", "driver", "inputs"}) | frozenset(
        {"own", "blank", "break", "options"}
    )

    def __init__(self, **options: Any) -> None:
        self.port: SimPort = open_sim(query(options))
        device: Any = self.port._device
        self._board = device.board

    def is_open(self) -> bool:
        return bool(self._board.bench.is_open)

    def reset(self, cause: int) -> None:
        from motorid.wire.enums import ResetCause

        self._board.reset(ResetCause(cause))

    def break_(self, fault: int, value: int) -> None:
        self._board.notice(Fault(fault), value)

    def complain(self, on: bool) -> None:
        if on:
            self._board.notice(Fault.DRIVER)

    def close_inputs(self, mask: int) -> None:
        self._board.set_inputs(mask)

    def spoil(self) -> None:
        raise NotImplementedError

    def close(self) -> None:
        self.port.close()


@cache
def module_of(path: Path) -> ModuleType:
    """A Python file that belongs to no package."""
    spec = importlib.util.spec_from_file_location(f"firmware_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


@lru_cache(maxsize=1)
def build_firmware(target: str = "all") -> Path:
    """The folder of what ``make`` built. Skips where it cannot build."""
    if sys.platform == "win32" or not shutil.which("make") or not shutil.which("gcc"):
        pytest.skip("no make and gcc: the firmware's host port is not built")
    with building():
        subprocess.run(["make", "-s", "-C", str(FIRMWARE), target], check=True)
    return FIRMWARE / "build"


def built_in_place(target: str, *parts: str, folder: Path) -> Path:
    """``folder`` with copies of these folders of firmware/build, after ``make`` saw to them.

    Every worker shares that build; nobody else writes into the copies.
    """
    with building():
        words = ["make", "-s", "-C", str(FIRMWARE), target]
        done = subprocess.run(words, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        for part in parts:
            shutil.copytree(FIRMWARE / "build" / part, folder / part)
    return folder


@contextlib.contextmanager
def building() -> Iterator[None]:
    """Several workers test at once; one builds."""
    import fcntl

    with (FIRMWARE / "Makefile").open("rb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


class HostBoard:
    """The portable core on this computer, in lock step."""

    name = "host"
    traits = SimulatedBoard.traits | {"memory"}

    def __init__(self, more: tuple[str, ...] = (), **options: Any) -> None:
        binary = build_firmware() / "host" / "board"
        arguments = [*module_of(HOST_PORT / "board.py").arguments(query(options)), *more]
        process = subprocess.Popen(
            [str(binary), "--socket", "0", "--speed", "lockstep", *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.port = LockStepPort(*connect(process), process)

    def is_open(self) -> bool:
        return self.port.is_open

    def reset(self, cause: int) -> None:
        self.port.order(f"reset {cause}")

    def break_(self, fault: int, value: int) -> None:
        self.port.order(f"break {fault} {value}")

    def complain(self, on: bool) -> None:
        if on:
            self.break_(Fault.DRIVER, 0)

    def close_inputs(self, mask: int) -> None:
        self.port.order(f"inputs {mask}")

    def spoil(self) -> None:
        self.port.order("spoil")

    def sense(self, volts: float, reference: float) -> None:
        """So many volts are at the input of the current's converter, whatever flows."""
        self.port.order(f"sense {volts!r} {reference!r}")

    def close(self) -> None:
        self.port.close()


@cache
def emulator_lacks(compiler: str = "gcc") -> str:
    """What keeps a board from being emulated here, or nothing."""
    path = FIRMWARE / "emulator" / "emu.py"
    if not path.exists():
        return "there is no firmware/emulator"
    return str(module_of(path).missing(compiler))


@cache
def pico_lacks() -> str:
    """The same of a Pico."""
    return str(module_of(FIRMWARE / "emulator" / "emu.py").missing_for_pico())


def compiled(name: str) -> tuple[str, str]:
    """The board of an emulated one's name, and its compiler."""
    chip, _, compiler = name.partition("-")
    return chip, compiler or "gcc"


# what that register says of each reset cause, by the data sheet
MCUSR = {
    ResetCause.POWER_ON: 1,
    ResetCause.EXTERNAL: 2,
    ResetCause.BROWN_OUT: 4,
    ResetCause.WATCHDOG: 8,
}


class EmulatedBoard:
    """The firmware that a real board is flashed with, on an emulated processor.

    "uno-clang" is the Uno with the second compiler's firmware.
    """

    traits = frozenset({"fresh", "exact", "bridge", "reset", "driver", "inputs", "own", "memory"})

    def __init__(self, name: str, **options: Any) -> None:
        self.name = name
        chip, compiler = compiled(name)
        given = {"speed": "max", "compiler": compiler, **options}
        pairs = "&".join(f"{key}={value}" for key, value in given.items())
        self.port: Any = self._opened(f"emu://{chip}?{pairs}")

    def _opened(self, url: str) -> Any:
        with building():
            return open_port(url)

    def is_open(self) -> bool:
        return not self.port.board.facts()["enabled"]

    def reset(self, cause: int) -> None:
        self.port.board.set("reset", MCUSR[ResetCause(cause)])

    def break_(self, fault: int, value: int) -> None:
        raise NotImplementedError

    def complain(self, on: bool) -> None:
        self.port.board.set("complain", float(on))

    def close_inputs(self, mask: int) -> None:
        self.port.board.set("inputs", float(mask))

    def spoil(self) -> None:
        for slot in range(2):
            self.port.board.set(f"eeprom[{FACTS_AT + slot * SLOT_BYTES + 20}]", 0x31)

    def close(self) -> None:
        self.port.close()


class EmulatedPico(EmulatedBoard):
    """The same of a Raspberry Pi Pico, whose flash holds facts.

    "pico-usb" is linked by its own USB.
    """

    traits = EmulatedBoard.traits - {"own"} | {"blank"}

    def __init__(self, name: str, **options: Any) -> None:
        over = {"link": "usb"} if name == "pico-usb" else {}
        super().__init__("pico", **over, **options)
        self.name = name

    def spoil(self) -> None:
        self.port.board.set("spoil", JOURNAL_AT)  # of the first sector that is ever used

    def _opened(self, url: str) -> Any:
        return POOL.take(url) or super()._opened(url)

    def reset(self, cause: int) -> None:
        self.port.board.set("reset", float(cause))

    def close(self) -> None:
        POOL.give(self.port)


class DeviceBoard:
    """A real board, with a motor that may turn."""

    name = "device"
    traits: frozenset[str] = frozenset()

    def __init__(self, url: str) -> None:
        self.port: Port = open_port(url)

    def is_open(self) -> bool:
        raise NotImplementedError

    def reset(self, cause: int) -> None:
        raise NotImplementedError

    def break_(self, fault: int, value: int) -> None:
        raise NotImplementedError

    def complain(self, on: bool) -> None:
        raise NotImplementedError

    def close_inputs(self, mask: int) -> None:
        raise NotImplementedError

    def spoil(self) -> None:
        raise NotImplementedError

    def close(self) -> None:
        self.port.close()


PICOS = ("pico", "pico-usb")
NAMES = ("sim", "host", "uno", "mega", "uno-clang", *PICOS, "device")


def open_board(name: str, device: str | None, **options: Any) -> Board:
    """A board by name. Skips, with the reason, where there is none."""
    if name == "sim":
        return SimulatedBoard(**options)
    if name == "host":
        return HostBoard(**options)
    if name == "device":
        assert device is not None, "its cases are deselected without --device PORT"
        return DeviceBoard(device)
    if lack := pico_lacks() if name in PICOS else emulator_lacks(compiled(name)[1]):
        pytest.skip(f"no emulated {name}: {lack}")
    return (EmulatedPico if name in PICOS else EmulatedBoard)(name, **options)


@contextlib.contextmanager
def opened(name: str, device: str | None = None, **options: Any) -> Iterator[Board]:
    """A board for the duration of a block."""
    board = open_board(name, device, **options)
    try:
        yield board
    finally:
        board.close()
