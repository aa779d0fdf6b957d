"""One station in a process of its own, and the line controller that orders from it."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from motorid import json_text

COMMAND = [sys.executable, "-m", "motorid.cli.main", "station", "--product", "sim-disc", "--rig",
           "sim-line", "--speed", "max", "--listen", "0"]  # fmt: skip
PATIENCE_S = 300.0
OLD_S = 60.0  # a journal that nobody writes to any more
INVALID = "INVALID"


class Station(threading.Thread):
    """Inspects ``serials`` one after the other, through all kills, until each is judged.

    Inspections are in ``folder``, and go on ``to`` the store.
    """

    def __init__(
        self, name: str, folder: Path, to: str, options: list[str], serials: list[str]
    ) -> None:
        super().__init__(name=name, daemon=True)
        self.folder, self.to, self.options, self.serials = folder, to, options, serials
        self.process: subprocess.Popen[str] | None = None
        self.shifts = self.accepted = 0
        self.link: socket.socket | None = None
        self.failed = ""

    def run(self) -> None:
        """See the class; what is not expected stands in ``failed``."""
        try:
            for serial in self.serials:
                self._judge(serial)
        except Exception as error:  # this thread's, said in the end
            self.failed = f"{self.name}: {error!r}"

    def _judge(self, serial: str) -> None:
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            with contextlib.suppress(OSError):  # it was killed: the next shift goes on
                if self.link is None:
                    self.begin()
                if self._known(serial):
                    return
                first = self.ask(order="inspect", serial=serial)
                self.accepted += first["event"] == "accepted"
                if first["event"] == "accepted" and self.hear()["outcome"] != INVALID:
                    return
                continue
            self.link = None
        raise TimeoutError(serial)

    def _known(self, serial: str) -> bool:
        """A shift that was killed may have judged it, or the next one from what it left."""
        return self.ask(order="last", serial=serial).get("outcome", INVALID) != INVALID

    def begin(self) -> None:
        """A new shift; where the last one was killed, its journals are nobody's any more."""
        self.end_process()
        for journal in self.folder.rglob("*.journal"):
            with contextlib.suppress(FileNotFoundError):
                os.utime(journal, (time.time() - OLD_S, time.time() - OLD_S))
        call = [*COMMAND, "-o", self.to, "--station", self.name, *self.options]
        self.process = subprocess.Popen(
            call,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.shifts += 1
        assert self.process.stderr is not None
        said = self.process.stderr.readline()
        if "listening on" not in said:
            raise ConnectionError(f"it was killed before it listened: {said}")
        port = int(said.rsplit(":", 1)[1])
        self.link = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
        self.lines = self.link.makefile("rb")

    def ask(self, **order: Any) -> dict[str, Any]:
        """The first answer to an order."""
        assert self.link is not None
        self.link.sendall(json_text.dumps(order).encode() + b"\n")
        return self.hear()

    def hear(self) -> dict[str, Any]:
        """The next answer. Raises ConnectionError at the end."""
        line = self.lines.readline()
        if not line.endswith(b"\n"):
            raise ConnectionError
        return dict(json_text.loads(line))

    def kill(self) -> None:
        """At once; from another thread."""
        if self.process is not None:
            self.process.kill()

    def finish(self, marks: tuple[str, ...]) -> list[str]:
        """A last shift, until each verdict has all ``marks``; the folders that still lack one."""
        self.begin()
        until = time.monotonic() + PATIENCE_S
        while (left := list(self._without(marks))) and time.monotonic() < until:
            time.sleep(0.2)
        self.ask(order="end")
        assert self.process is not None
        self.process.wait(PATIENCE_S)
        return left

    def _without(self, marks: tuple[str, ...]) -> Iterator[str]:
        for verdict in self.folder.glob("*/verdict.json"):
            if not all((verdict.parent / mark).exists() for mark in marks):
                yield f"{self.name}: {verdict.parent.name} lacks a mark of {', '.join(marks)}"

    def end_process(self) -> None:
        """No process of this station is left."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None
