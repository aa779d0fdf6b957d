"""A board in a process of its own that moves as the client asks, and the link to it."""

from __future__ import annotations

import contextlib
import socket
import subprocess
from typing import IO, Any

from motorid.errors import LinkError

STRETCH = 16  # samples by which the board moves while nothing has arrived


class LockStepPort:
    """A board in a process of its own, whose time moves only while the client waits in ``read``.

    The process takes lines "advance SAMPLES BYTES" and answers each by "SECONDS BYTES OPEN", as
    firmware/ports/host/main.c has it; the bytes themselves go by ``link``.
    """

    def __init__(self, name: str, link: socket.socket, process: subprocess.Popen[str]) -> None:
        self.name = name
        self._link, self._process = link, process
        self._written = self._received = self._sent = 0
        self._seconds = 0.0
        self.step_s = 0.0  # of the latest sample period
        self.is_open = True
        self.order("advance 0 0")

    def order(self, text: str) -> None:
        """One line to the process, and its answer."""
        orders, answers = self._process.stdin, self._process.stdout
        assert orders is not None
        assert answers is not None
        orders.write(text + "\n")
        orders.flush()
        words = answers.readline().split()
        if len(words) != 3:
            raise LinkError(f"{self.name}: the board's process has ended")
        self._seconds, self._sent, self.is_open = float(words[0]), int(words[1]), words[2] == "1"

    def advance(self, samples: int) -> None:
        """Let sample periods pass."""
        before = self._seconds
        self.order(f"advance {samples} {self._written}")
        self.step_s = (self._seconds - before) / samples

    def read(self, size: int, timeout_s: float) -> bytes:
        deadline = self._seconds + timeout_s
        while self._received == self._sent:
            if self._seconds >= deadline:
                return b""
            left = (deadline - self._seconds) / self.step_s if self.step_s else 1.0
            self.advance(max(1, min(STRETCH, round(left))))
        data = self._link.recv(min(size, self._sent - self._received))
        self._received += len(data)
        return data

    def write(self, data: bytes) -> None:
        self._link.sendall(data)
        self._written += len(data)

    def now(self) -> float:
        return self._seconds

    def close(self) -> None:
        self._link.close()
        stop(self._process)


def stop(process: subprocess.Popen[Any]) -> None:
    """End a process, and its pipes."""
    process.terminate()
    process.wait(10)
    streams: list[IO[Any] | None] = [process.stdin, process.stdout]
    for stream in streams:
        if stream is not None:
            with contextlib.suppress(BrokenPipeError):
                stream.close()


def connect(process: subprocess.Popen[str]) -> tuple[str, socket.socket]:
    """The URL that a board's process prints first, and a link to it."""
    assert process.stdout is not None
    url = process.stdout.readline().strip()
    host, _, number = url.removeprefix("socket://").rpartition(":")
    link = socket.create_connection((host, int(number)), timeout=30)
    link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return url, link
