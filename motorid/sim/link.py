"""The cable: paces what the board says by the baud rate, and spoils bytes when told to."""

from __future__ import annotations

from collections import deque

import numpy as np

BITS_PER_BYTE = 10  # start, eight, stop


class Spoiler:
    """Rates per byte of the ways in which a line corrupts what passes. Deterministic by seed."""

    def __init__(self, seed: int) -> None:
        self.rates = {"flip": 0.0, "drop": 0.0, "insert": 0.0, "double": 0.0}
        self._rng = np.random.default_rng([seed, 4])

    def spoil(self, data: bytes) -> bytes:
        """What arrives of ``data``."""
        if not any(self.rates.values()):
            return data
        out = bytearray()
        chances = self._rng.random((len(data), 4)) < list(self.rates.values())
        others = self._rng.integers(0, 256, len(data))
        for byte, chance, other in zip(data, chances, others.tolist(), strict=True):
            flip, drop, insert, double = chance
            if insert:
                out.append(other)
            if flip:
                byte ^= 1 << (other & 7)
            if not drop:
                out += bytes([byte]) * (2 if double else 1)
        return bytes(out)


class Link:
    """Bytes on their way from the board to the host.

    A frame arrives as a whole when its last bit has passed at ``baud`` (0: at once); with
    ``lump_s`` above 0 not before the next multiple of that time.
    """

    def __init__(self, baud: int, seed: int) -> None:
        self.baud = baud
        self.lump_s = 0.0
        self.dead = False  # nothing leaves the board any more
        self.spoiler = Spoiler(seed)
        self._frames: deque[tuple[float, bytes]] = deque()
        self._free = 0.0  # when the line has sent all that was given to it
        self._rest = b""

    def send(self, frame: bytes, now: float) -> None:
        """The board hands over a frame."""
        if self.dead:
            return
        self._free = max(self._free, now)
        if self.baud:
            self._free += len(frame) * BITS_PER_BYTE / self.baud
        arrival = self._free
        if self.lump_s:
            arrival = (arrival // self.lump_s + 1) * self.lump_s
        self._frames.append((arrival, self.spoiler.spoil(frame)))

    def backlog(self, now: float) -> float:
        """Bytes that still wait for the line."""
        return max(self._free - now, 0.0) * self.baud / BITS_PER_BYTE

    def take(self, size: int, now: float) -> bytes:
        """At most ``size`` of the bytes that have arrived."""
        while len(self._rest) < size and self._frames and self._frames[0][0] <= now:
            self._rest += self._frames.popleft()[1]
        data, self._rest = self._rest[:size], self._rest[size:]
        return data
