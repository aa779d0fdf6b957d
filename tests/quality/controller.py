"""A line controller, as the station's tests need one."""

from __future__ import annotations

import json
import socket
from typing import Any


class Controller:
    """A line controller: one connection, JSON lines."""

    def __init__(self, port: int) -> None:
        self.link = socket.create_connection(("127.0.0.1", port), timeout=240)
        self.file = self.link.makefile("rwb")

    def say(self, line: bytes) -> None:
        self.file.write(line + b"\n")
        self.file.flush()

    def hear(self) -> dict[str, Any]:
        return dict(json.loads(self.file.readline()))

    def ask(self, **order: Any) -> dict[str, Any]:
        self.say(json.dumps(order).encode())
        return self.hear()
