"""Ports that are absent, busy, or something else: one sentence each, and never a hang."""

from __future__ import annotations

import os
import socket
import sys
import threading
from pathlib import Path

import pytest

from motorid.acquire.port import open_port
from motorid.acquire.ports import list_ports, listing, probe
from motorid.errors import LinkError, UsageError

posix = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("", "no port is named"),
        ("foo://bar", "unknown kind foo://"),
        ("socket://nowhere", "write socket://HOST:PORT"),
        ("socket://host:port", "write socket://HOST:PORT"),
        ("/dev/ttyX?bod=1", "unknown option bod"),
        ("/dev/ttyX?baud=fast", "baud must be a number"),
        ("sim://?motr=x", "motor"),
    ],
)
def test_a_senseless_url_is_a_usage_error(url: str, says: str) -> None:
    with pytest.raises(UsageError) as caught:
        open_port(url)
    assert says in str(caught.value)


def test_an_absent_port_is_named() -> None:
    with pytest.raises(LinkError, match="no such port; `motorid ports` lists"):
        open_port("/dev/no-such-port" if sys.platform != "win32" else "COM99")


def test_a_file_is_no_port(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_text("hello")
    with pytest.raises(LinkError, match=r"cannot be opened as a serial port|no such port"):
        open_port(str(path))


def test_nobody_listens() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))  # and keeps the number from other tests
        number = free.getsockname()[1]
        with pytest.raises(LinkError, match="is it listening there"):
            open_port(f"socket://127.0.0.1:{number}")


def test_a_socket_carries_bytes_and_says_when_it_closes() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:

        def echo() -> None:
            link, _ = server.accept()
            with link:
                link.sendall(link.recv(100)[::-1])

        thread = threading.Thread(target=echo)
        thread.start()
        port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}")
        try:
            assert port.read(10, 0.01) == b""
            port.write(b"abc")
            assert port.read(10, 60.0) == b"cba"
            with pytest.raises(LinkError, match="closed the link"):
                port.read(10, 60.0)
        finally:
            port.close()
            thread.join()


@pytest.mark.slow
def test_a_long_write_waits_for_a_slow_reader_though_a_short_read_came_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("motorid.acquire.port.WRITE_S", 60.0)  # a busy computer changes nothing
    many, asked = 8_000_000, threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:
        got: list[int] = []

        def late() -> None:
            link, _ = server.accept()
            with link:
                asked.wait(60.0)
                while sum(got) < many and (data := link.recv(1 << 20)):
                    got.append(len(data))

        thread = threading.Thread(target=late)
        thread.start()
        port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}")
        timer = threading.Timer(0.1, asked.set)
        try:
            assert port.read(1, 1e-4) == b""
            timer.start()
            port.write(bytes(many))
        finally:
            asked.set()
            port.close()
            thread.join()
    assert sum(got) == many


@posix
def test_a_terminal_carries_bytes_and_is_held_alone() -> None:
    host, device = os.openpty()
    name = os.ttyname(device)
    port = open_port(name)
    try:
        os.write(host, b"from the board")
        got = b""
        while len(got) < 14:
            got += port.read(4096, 1.0)
        assert got == b"from the board"
        port.write(b"\0to it")
        assert os.read(host, 100) == b"\0to it"
        assert port.read(10, 0.01) == b""
        with pytest.raises(LinkError, match="another program holds this port") as caught:
            open_port(name)
        assert f"process {os.getpid()}," not in str(caught.value)  # we are not the other one
    finally:
        port.close()
        os.close(host)
        os.close(device)


@posix
def test_a_pulled_cable_is_said() -> None:
    host, device = os.openpty()
    port = open_port(os.ttyname(device))
    os.close(device)
    os.close(host)
    try:
        with pytest.raises(LinkError, match="the link broke"):
            port.read(10, 0.2)
    finally:
        port.close()
        port.close()


def test_listing_opens_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(url: str) -> None:
        raise AssertionError(f"{url} was opened")

    monkeypatch.setattr("motorid.acquire.ports.open_port", refuse)
    assert len(list(listing())) == max(1, len(list_ports()))


@pytest.mark.slow
def test_probing_says_who_answers() -> None:
    assert probe("sim://?speed=max") == "motorid-sim, firmware 1.0.0, protocol 1.3"
    assert "not motorid's protocol" in probe("sim://?speed=max&fault=text")
    assert "no such port" in probe("/dev/no-such-port")
