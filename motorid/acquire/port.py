"""A URL becomes a port: sim://, replay://, relay://, socket://, or a serial device."""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import os
import socket
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import parse_qs, urlsplit

from motorid.acquire.link import Port as Port  # who opens one names its type
from motorid.errors import LinkError, UsageError
from motorid.wire.spec import load

if TYPE_CHECKING:
    import serial

INSTRUMENTS = "scpi://"  # names a file of instruments, behind which there is no board
CONNECT_S = 5.0
WRITE_S = 2.0


def open_port(url: str) -> Port:
    """The port that ``url`` names.

    ``sim://?motor=…``, ``replay://JOURNAL``, ``relay://?fault=…&to=PORT``, ``socket://HOST:PORT``,
    or a serial device's name (``/dev/ttyACM0``, ``COM3``), perhaps with ``?baud=115200``.
    Raises LinkError when it cannot be opened, UsageError when the URL makes no sense. Never waits
    longer than a few seconds.
    """
    if not url:
        raise UsageError("no port is named: write port = … in the rig file, or use --port")
    scheme, separator, rest = url.partition("://")
    if not separator:
        return _open_serial(url)
    match scheme:
        case "sim":
            from motorid.sim.port import open_sim

            return open_sim(url)
        case "replay":
            from motorid.acquire.replay import ReplayPort

            return ReplayPort(rest)
        case "relay":
            from motorid.acquire.relay import open_relay

            return open_relay(url, open_port)
        case "socket":
            return _open_socket(url)
        case "emu":
            return _open_emulated(url)
        case "scpi":
            raise UsageError(
                f"port {url}: instruments are no board; `motorid capture` and `motorid run` record "
                "with them, and all that begins with a capture goes on from there"
            )
    raise UsageError(
        f"port {url}: unknown kind {scheme}://; use sim, replay, relay, socket, scpi or a device"
    )


class SerialPort:
    """A serial device by pyserial."""

    def __init__(self, name: str, device: serial.Serial) -> None:
        self.name = name
        self._device = device

    def read(self, size: int, timeout_s: float) -> bytes:
        """See Port."""
        try:
            self._device.timeout = timeout_s
            head: bytes = self._device.read(1)
            waiting = min(size - 1, self._device.in_waiting) if head else 0
            return head + self._device.read(waiting) if waiting else head
        except (OSError, TypeError) as error:  # TypeError: pyserial, when closed meanwhile
            raise _gone(self.name, error) from None

    def write(self, data: bytes) -> None:
        """See Port."""
        try:
            self._device.write(data)
        except OSError as error:
            raise _gone(self.name, error) from None

    def now(self) -> float:
        """See Port."""
        return time.monotonic()

    def close(self) -> None:
        """See Port."""
        self._device.close()


class SocketPort:
    """A TCP link, such as an emulated board's serial line."""

    def __init__(self, name: str, link: socket.socket) -> None:
        self.name = name
        self._link = link

    def read(self, size: int, timeout_s: float) -> bytes:
        """See Port."""
        try:
            self._link.settimeout(max(timeout_s, 1e-4))
            data = self._link.recv(size)
        except TimeoutError:
            return b""
        except OSError as error:
            raise _gone(self.name, error) from None
        if not data:
            raise LinkError(f"{self.name}: the other side closed the link")
        return data

    def write(self, data: bytes) -> None:
        """See Port."""
        try:
            self._link.settimeout(WRITE_S)
            self._link.sendall(data)
        except OSError as error:
            raise _gone(self.name, error) from None

    def now(self) -> float:
        """See Port."""
        return time.monotonic()

    def close(self) -> None:
        """See Port."""
        self._link.close()


def _open_socket(url: str) -> SocketPort:
    try:
        parts = urlsplit(url)
        host, number = parts.hostname, parts.port
    except ValueError:
        host = number = None
    if not host or not number:
        raise UsageError(f"port {url}: write socket://HOST:PORT")
    try:
        link = socket.create_connection((host, number), timeout=CONNECT_S)
    except OSError as error:
        raise LinkError(
            f"{url}: no connection ({error.strerror or error}): is it listening there?"
        ) from None
    link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return SocketPort(url, link)


def _open_emulated(url: str) -> Port:
    """The firmware on an emulated board, by a harness that is not in the package."""
    path = Path(__file__).parents[2] / "firmware" / "emulator" / "emu.py"
    spec = importlib.util.spec_from_file_location("motorid_emulator", path)
    if not path.is_file() or spec is None or spec.loader is None:
        raise UsageError(f"port {url}: emu:// needs a checkout of motorid; sim:// works everywhere")
    module = sys.modules.get(spec.name)
    if module is None:
        module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    port: Port = module.open_emu(url)
    return port


def _open_serial(url: str) -> SerialPort:
    import serial

    name, _, query = url.partition("?")
    options = parse_qs(query)
    if unknown := set(options) - {"baud"}:
        raise UsageError(f"port {url}: unknown option {sorted(unknown)[0]}; the only one is baud")
    baud = options.get("baud", [str(load().baud)])[-1]
    if not baud.isdecimal() or not 0 < int(baud) <= 20_000_000:
        raise UsageError(f"port {url}: baud must be a number of bits a second, not {baud!r}")
    try:
        device = serial.Serial(name, int(baud), timeout=0.0, write_timeout=WRITE_S, exclusive=True)
    except (OSError, ValueError) as error:
        raise LinkError(_why_not(name, error)) from None
    return SerialPort(name, device)


def _why_not(name: str, error: Exception) -> str:
    """Why a device did not open, and what to do, in one sentence."""
    number = getattr(error, "errno", None)
    text = str(error)
    if number == errno.ENOENT or "FileNotFoundError" in text:
        return f"{name}: no such port; `motorid ports` lists those present"
    if number == errno.EACCES or "PermissionError" in text:
        return (
            f"{name}: permission denied, or another program holds it; on Linux add yourself to "
            "the group that owns the device (often dialout) and log in again"
        )
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text:
        return f"{name}: another program holds this port{_holder(name)}; close it there first"
    return f"{name}: cannot be opened as a serial port ({text.splitlines()[0][:120]})"


def _holder(name: str) -> str:
    """Which process has a device open, in brackets, where the system tells (Linux)."""
    device = os.path.realpath(name)
    if owner := _lock_owner(device):
        return owner
    for handle in Path("/proc").glob("[0-9]*/fd/*"):
        with contextlib.suppress(OSError):  # not ours to see, or gone meanwhile
            if os.readlink(handle) == device and handle.parts[2] != str(os.getpid()):
                command = Path("/proc", handle.parts[2], "comm").read_text().strip()
                return f" (process {handle.parts[2]}, {command})"
    return ""


def _lock_owner(device: str) -> str:
    """The process whose lock keeps others out, of all that may have the device open (Linux)."""
    with contextlib.suppress(OSError, IndexError):
        number = f":{os.stat(device).st_ino}"
        for line in Path("/proc/locks").read_text(encoding="ascii").splitlines():
            words = line.split()  # 1: FLOCK ADVISORY WRITE PID MAJOR:MINOR:INODE ...
            if words[1] == "FLOCK" and words[5].endswith(number) and words[4] != str(os.getpid()):
                command = Path("/proc", words[4], "comm").read_text(encoding="utf-8").strip()
                return f" (process {words[4]}, {command})"
    return ""


def _gone(name: str, error: Exception) -> LinkError:
    return LinkError(f"{name}: the link broke ({error}): check the cable and the board's power")
