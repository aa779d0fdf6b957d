"""Emulated Picos that serve one test after the other.

A process that has run before makes a new board on a new bench in a fifth of the time that a new one
takes: its compiler knows the emulator's code by then. Such a board says the same to the byte.
"""

from __future__ import annotations

import atexit
import contextlib
from typing import Any

from motorid.errors import LinkError

MOST = 3  # that wait


class Pool:
    """Ports that nobody uses."""

    def __init__(self) -> None:
        self._free: list[Any] = []

    def take(self, url: str) -> Any | None:
        """A new board as the URL has it; None where none waits."""
        for port in reversed(self._free):
            if port.name == url:
                self._free.remove(port)
                with contextlib.suppress(LinkError):  # it died
                    port.board.renew()
                    return port
                port.close()
        return None

    def give(self, port: Any) -> None:
        """It is done with; may be given twice."""
        if port not in self._free:
            self._free.append(port)
        while len(self._free) > MOST:
            self._free.pop(0).close()

    def close(self) -> None:
        """End them all."""
        while self._free:
            self._free.pop().close()


POOL = Pool()
atexit.register(POOL.close)
