"""Debian's mosquitto on loopback, which tests start, kill, stop and start again."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

PROGRAM = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")
ABSENT = "mosquitto is not installed: no broker to test with"
PATIENCE_S = 120.0


class Mosquitto:
    """One broker on a port of its own; ``lines`` are of its configuration."""

    def __init__(self, folder: Path, *lines: str) -> None:
        self.port = free_port()
        self.configuration = folder / "mosquitto.conf"
        said = [f"listener {self.port} 127.0.0.1", *(lines or ("allow_anonymous true",))]
        if os.geteuid() == 0:
            said.insert(0, "user root")  # else it could not read keys in a folder of ours
        self.configuration.write_text("\n".join([*said, ""]))
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Listens when this returns."""
        assert PROGRAM is not None
        words = [PROGRAM, "-c", str(self.configuration)]
        self.process = subprocess.Popen(words, stderr=subprocess.DEVNULL)
        until = time.monotonic() + PATIENCE_S
        while True:
            with contextlib.suppress(OSError):
                socket.create_connection(("127.0.0.1", self.port), timeout=5).close()
                return
            assert self.process.poll() is None, "mosquitto ended"
            assert time.monotonic() < until, "mosquitto does not listen"
            time.sleep(0.05)

    def signal(self, number: signal.Signals) -> None:
        """As SIGSTOP, after which it hangs, and SIGCONT."""
        assert self.process is not None
        self.process.send_signal(number)

    def kill(self) -> None:
        """At once, with what it holds in memory."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None


@contextlib.contextmanager
def broker(folder: Path, *lines: str) -> Iterator[Mosquitto]:
    """A running one."""
    one = Mosquitto(folder, *lines)
    one.start()
    try:
        yield one
    finally:
        one.kill()


def free_port() -> int:
    """Nobody listens there just now."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return int(taken.getsockname()[1])
