"""What a port's name opens, and how: by devices, sockets and files that are made for it."""

from __future__ import annotations

import errno
import os
import socket
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import serial

from motorid.acquire import port as room
from motorid.acquire.port import SerialPort, SocketPort, open_port
from motorid.errors import LinkError, UsageError
from motorid.wire.spec import load


class Device:
    """A serial device with so many bytes waiting, or one that fails."""

    def __init__(self, waiting: bytes = b"", fails: Exception | None = None) -> None:
        self.waiting, self.fails = waiting, fails
        self.timeout, self.asked, self.sent, self.closed = -1.0, list[int](), b"", 0

    @property
    def in_waiting(self) -> int:
        return len(self.waiting)

    def read(self, size: int) -> bytes:
        if self.fails is not None:
            raise self.fails
        self.asked.append(size)
        data, self.waiting = self.waiting[:size], self.waiting[size:]
        return data

    def write(self, data: bytes) -> None:
        if self.fails is not None:
            raise self.fails
        self.sent += data

    def close(self) -> None:
        self.closed += 1


@pytest.mark.parametrize(
    ("waiting", "size", "got", "asked"),
    [
        (b"", 5, b"", [1]),
        (b"a", 5, b"a", [1]),
        (b"abc", 5, b"abc", [1, 2]),
        (b"abcdefgh", 5, b"abcde", [1, 4]),
        (b"abc", 1, b"a", [1]),
    ],
)
def test_a_device_gives_what_waits_and_no_more_than_asked(
    waiting: bytes, size: int, got: bytes, asked: list[int]
) -> None:
    device: Any = Device(waiting)
    port = SerialPort("P", device)
    assert port.read(size, 0.25) == got
    assert (device.asked, device.timeout) == (asked, 0.25)
    port.write(b"to it")
    port.close()
    assert (device.sent, device.closed) == (b"to it", 1)


@pytest.mark.parametrize("error", [OSError("gone"), TypeError("gone")])
def test_a_device_that_fails_is_a_broken_link(error: Exception) -> None:
    device: Any = Device(fails=error)
    says = r"P: the link broke \(gone\): check the cable"
    with pytest.raises(LinkError, match=says):
        SerialPort("P", device).read(5, 0.1)
    if isinstance(error, OSError):
        with pytest.raises(LinkError, match=says):
            SerialPort("P", device).write(b"x")


def test_a_port_s_clock_is_the_computer_s(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "time", SimpleNamespace(monotonic=lambda: 12.5))
    nothing: Any = None
    assert [SerialPort("P", nothing).now(), SocketPort("P", nothing).now()] == [12.5, 12.5]


@pytest.mark.parametrize(
    ("query", "baud"),
    [
        ("", load().baud), ("?baud=9600", 9600), ("?baud=9600&baud=57600", 57600), ("?baud=1", 1),
        ("?baud=20000000", 20_000_000), ("?baud=0", 0), ("?baud=20000001", 0), ("?baud=-1", 0),
    ],
)  # fmt: skip
def test_a_device_is_opened_for_us_alone_at_its_rate(
    query: str, baud: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[Any] = []
    monkeypatch.setattr(serial, "Serial", lambda *words, **more: opened.append((words, more)))
    if not baud:
        with pytest.raises(UsageError, match="baud must be a number of bits a second, not '"):
            open_port(f"/dev/board{query}")
        return
    assert open_port(f"/dev/board{query}").name == "/dev/board"
    assert opened == [
        (("/dev/board", baud), {"timeout": 0.0, "write_timeout": 2.0, "exclusive": True})
    ]


ABSENT = "P: no such port; `motorid ports` lists those present"
DENIED = "P: permission denied, or another program holds it; on Linux add yourself to the group "
HELD = "P: another program holds this port (process 7, other); close it there first"


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (OSError(errno.ENOENT, "x"), ABSENT),
        (ValueError("FileNotFoundError(2, 'x')"), ABSENT),
        (OSError(errno.EACCES, "x"), DENIED),
        (OSError("PermissionError(13, 'x')"), DENIED),
        (OSError(errno.EBUSY, "x"), HELD),
        (OSError(errno.EAGAIN, "x"), HELD),
        (OSError("Could not exclusively lock port"), HELD),
        (ValueError("odd\nmore of it"), "P: cannot be opened as a serial port (odd)"),
        (ValueError("y" * 121), f"P: cannot be opened as a serial port ({'y' * 120})"),
    ],
)
def test_why_a_device_does_not_open(
    error: Exception, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*words: object, **more: object) -> None:
        raise error

    monkeypatch.setattr(serial, "Serial", fails)
    monkeypatch.setattr(room, "_holder", lambda name: " (process 7, other)")
    with pytest.raises(LinkError) as caught:
        open_port("P")
    assert str(caught.value).startswith(says)
    assert (str(caught.value) == says) == (says != DENIED)


def test_who_holds_a_device_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """This process, taken for another one: as it holds the file open, then as it has locked it."""
    if not Path("/proc/self/fd").is_dir():
        return
    import fcntl

    me, name = os.getpid(), Path("/proc/self/comm").read_text(encoding="utf-8").strip()
    path, link = tmp_path / "device", tmp_path / "link"
    path.write_bytes(b"")
    link.symlink_to(path)
    with path.open("rb+") as file:
        assert room._holder(str(link)) == ""
        monkeypatch.setattr(room, "os", SimpleNamespace(**vars(os) | {"getpid": lambda: 0}))
        assert room._holder(str(link)) == f" (process {me}, {name})"
        assert room._lock_owner(str(path)) == ""
        fcntl.flock(file.fileno(), fcntl.LOCK_EX)
        known = str(path.stat().st_ino) in Path("/proc/locks").read_text(encoding="ascii")
        assert room._lock_owner(str(path)) == (f" (process {me}, {name})" if known else "")
        assert room._lock_owner(str(tmp_path)) == ""
    assert room._holder(str(link)) == ""


LOCKS = """\
1: POSIX  ADVISORY  WRITE 41 00:2b:{inode} 0 EOF
2: FLOCK  ADVISORY  WRITE 42 00:2b:9{inode} 0 EOF
3: FLOCK  ADVISORY  WRITE {me} 00:2b:{inode} 0 EOF
4: FLOCK  ADVISORY  WRITE 43 00:2b:{inode} 0 EOF
"""


def test_a_lock_s_owner_stands_in_the_system_s_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inode, me = os.stat(tmp_path).st_ino, os.getpid()
    (tmp_path / "locks").write_text(LOCKS.format(inode=inode, me=me))
    for number in (41, 42, 43, me):
        (tmp_path / str(number)).mkdir()
        (tmp_path / str(number) / "comm").write_text(f"program {number}\n")
    monkeypatch.setattr(room, "Path", lambda *parts: tmp_path.joinpath("", *_within(parts)))
    assert room._lock_owner(str(tmp_path)) == " (process 43, program 43)"
    (tmp_path / "locks").write_text("5: FLOCK\n")
    assert room._lock_owner(str(tmp_path)) == ""


def _within(parts: tuple[str, ...]) -> list[str]:
    return "/".join(parts).removeprefix("/proc").strip("/").split("/")


# -- sockets
class Line:
    """A connected socket that notes what it is told."""

    def __init__(self, *heard: Any) -> None:
        self.heard, self.told = list(heard), list[Any]()

    def settimeout(self, seconds: float) -> None:
        self.told.append(seconds)

    def setsockopt(self, *what: int) -> None:
        self.told.append(what)

    def recv(self, size: int) -> bytes:
        found = self.heard.pop(0)
        if isinstance(found, Exception):
            raise found
        return bytes(found[:size])

    def sendall(self, data: bytes) -> None:
        if self.heard:
            raise self.heard.pop(0)
        self.told.append(data)

    def close(self) -> None:
        self.told.append("closed")


def test_a_socket_waits_as_long_as_asked_and_longer_to_write() -> None:
    line: Any = Line(b"abcdef", TimeoutError(), b"", OSError("reset"))
    port = SocketPort("P", line)
    assert (port.read(4, 0.25), port.read(4, 0.0)) == (b"abcd", b"")
    with pytest.raises(LinkError, match="P: the other side closed the link"):
        port.read(4, 0.5)
    with pytest.raises(LinkError, match=r"P: the link broke \(reset\)"):
        port.read(4, 0.5)
    assert line.told == [0.25, 1e-4, 0.5, 0.5]  # a socket of no time-out would not block
    port.write(b"x")
    port.close()
    assert line.told[4:] == [2.0, b"x", "closed"]
    line.heard = [OSError("broken")]
    with pytest.raises(LinkError, match=r"P: the link broke \(broken\)"):
        port.write(b"x")


@pytest.mark.parametrize("url", ["socket://:80", "socket://host", "socket://h:0", "socket://h:1e5"])
def test_an_address_has_a_host_and_a_port(url: str) -> None:
    with pytest.raises(UsageError, match="write socket://HOST:PORT"):
        open_port(url)


def test_a_connection_is_made_in_a_few_seconds_and_sends_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []
    line = Line()

    def connect(address: Any, timeout: float) -> Any:
        asked.append((address, timeout))
        return line

    monkeypatch.setattr(room.socket, "create_connection", connect)
    assert open_port("socket://host:81").name == "socket://host:81"
    assert asked == [(("host", 81), 5.0)]
    assert line.told == [(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)]


@pytest.mark.parametrize("error", [OSError(1, "refused"), TimeoutError("refused")])
def test_no_connection_says_why(error: OSError, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*words: object, **more: object) -> None:
        raise error

    monkeypatch.setattr(room.socket, "create_connection", fails)
    with pytest.raises(LinkError, match=r"^socket://h:9: no connection \(refused\): is it listen"):
        open_port("socket://h:9")


# -- what is not in the package, and what is no board
def test_an_emulated_board_needs_a_checkout(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "__file__", str(tmp_path / "motorid" / "acquire" / "port.py"))
    monkeypatch.setitem(sys.modules, "motorid_emulator", None)  # none is loaded yet
    with pytest.raises(UsageError, match="port emu://uno: emu:// needs a checkout of motorid"):
        open_port("emu://uno")
    harness = tmp_path / "firmware" / "emulator" / "emu.py"
    harness.parent.mkdir(parents=True)
    harness.write_text("opened = []\ndef open_emu(url):\n    opened.append(url)\n    return opened")
    assert open_port("emu://uno") == ["emu://uno"]
    assert open_port("emu://mega") == ["emu://uno", "emu://mega"]  # by the same module


def test_instruments_are_no_board() -> None:
    with pytest.raises(UsageError, match="port scpi://x: instruments are no board"):
        open_port("scpi://x")
