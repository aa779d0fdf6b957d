"""What a byte link to one board is, whatever carries it."""

from __future__ import annotations

from typing import Protocol


class Port(Protocol):
    """A byte link to one board, and the clock that its time-outs go by."""

    name: str

    def read(self, size: int, timeout_s: float) -> bytes:
        """At most ``size`` bytes as soon as any are there; empty after ``timeout_s``.

        Raises LinkError when the link is gone.
        """

    def write(self, data: bytes) -> None:
        """Sends all of ``data``. Raises LinkError when the link is gone or stuck."""

    def now(self) -> float:
        """Seconds, monotonic; a simulated port at full speed returns its own time."""

    def close(self) -> None:
        """Gives the link back; may be called twice."""
