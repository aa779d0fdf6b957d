"""The cable: paces what the board says by the baud rate, and spoils bytes when told to."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from motorid.sim.faults import Fault

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
    """Bytes on their way in one direction.

    A frame arrives as a whole when its last bit has passed at ``baud`` (0: at once), ``delay_s``
    later than that, and with ``lump_s`` above 0 not before the next multiple of that time.
    """

    def __init__(self, baud: int, spoiler: Spoiler) -> None:
        self.baud = baud
        self.delay_s = 0.0
        self.lump_s = 0.0
        self.dead = False  # nothing gets through any more
        self.spoiler = spoiler
        self._frames: deque[tuple[float, bytes]] = deque()
        self._free = 0.0  # when the line has sent all that was given to it
        self._rest = b""

    def send(self, frame: bytes, now: float) -> None:
        """A frame, or any bytes, are handed over at this end."""
        if self.dead or not frame:
            return
        self._free = max(self._free, now)
        if self.baud:
            self._free += len(frame) * BITS_PER_BYTE / self.baud
        arrival = self._free + self.delay_s
        if self.lump_s:
            arrival = (arrival // self.lump_s + 1) * self.lump_s
        if self._frames:  # a link keeps its order, also when a delay ends
            arrival = max(arrival, self._frames[-1][0])
        self._frames.append((arrival, self.spoiler.spoil(frame)))

    @property
    def due(self) -> float:
        """When the next bytes arrive; infinite while none are on their way."""
        if self._rest:
            return -math.inf
        return self._frames[0][0] if self._frames else math.inf

    def backlog(self, now: float) -> float:
        """Bytes that still wait for the line."""
        return max(self._free - now, 0.0) * self.baud / BITS_PER_BYTE

    def take(self, size: int, now: float) -> bytes:
        """At most ``size`` of the bytes that have arrived."""
        while len(self._rest) < size and self._frames and self._frames[0][0] <= now:
            self._rest += self._frames.popleft()[1]
        data, self._rest = self._rest[:size], self._rest[size:]
        return data


class Cable:
    """A link each way between a board and a host, and the faults that befall both alike."""

    def __init__(self, baud: int, seed: int) -> None:
        self.spoiler = Spoiler(seed)
        self.up = Link(baud, self.spoiler)  # from the board to the host
        self.down = Link(0, self.spoiler)
        self.unplugged = False
        self.split = False
        self._rng = np.random.default_rng([seed, 6])

    def take(self, size: int, now: float) -> bytes:
        """What the host reads."""
        if self.split:
            size = min(size, int(self._rng.integers(1, 8)))
        return self.up.take(size, now)

    def apply(self, fault: Fault, on: bool = True) -> bool:
        """Begins a fault, or ends it; False where it is none of a cable's."""
        match fault.name:
            case "flip" | "drop" | "insert" | "double":
                self.spoiler.rates[fault.name] = fault.value if on else 0.0
            case "silence":
                self.up.dead = self.down.dead = on
            case "deaf":
                self.down.dead = on
            case "mute":
                self.up.dead = on
            case "unplug":
                self.unplugged = on
            case "delay":
                self.up.delay_s = self.down.delay_s = fault.value if on else 0.0
            case "burst":
                self.up.lump_s = fault.value if on else 0.0
            case "split":
                self.split = on
            case _:
                return False
        return True
