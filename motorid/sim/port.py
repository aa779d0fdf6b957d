"""sim:// as a port: the simulated board below the bytes, on wall time or on its own."""

from __future__ import annotations

import time

from motorid.errors import LinkError
from motorid.sim.device import Device
from motorid.sim.options import Options, parse_url

POLL_S = 1e-3
HICCUP_S = 0.02  # a poll that takes longer was kept waiting by the system
STRETCH = 32  # samples by which simulated time moves while nothing has arrived
STRETCH_S = 5e-3  # and the longest such stretch: a reply comes no later


class SimPort:
    """A port whose time is simulated: it moves only while the client waits in ``read``.

    So a client that keeps reading gets a run as fast as the plant computes, one that counts its
    deadlines on ``now`` sees them scaled, and one that stops reading stops the rig.
    """

    def __init__(self, name: str, options: Options) -> None:
        self.name = name
        self._device = Device(options)
        self._waited_until = 0.0  # waits may be shorter than the board's sample period
        self._closed = False

    def read(self, size: int, timeout_s: float) -> bytes:
        """At most ``size`` bytes as soon as any are there; empty after ``timeout_s``.

        Raises LinkError when the simulated cable is out.
        """
        device = self._check()
        deadline = self.now() + timeout_s
        while not (data := device.take(size)):
            device.check()
            if device.now + device.step_s > deadline:
                self._waited_until = deadline
                return b""
            stretch = max(min(STRETCH * device.step_s, STRETCH_S), device.step_s)
            device.advance_to(min(deadline, device.now + stretch))
        return data

    def write(self, data: bytes) -> None:
        """Bytes to the board, which acts on them at once. Raises LinkError."""
        self._check().hear(data, self.now())

    def now(self) -> float:
        """Simulated seconds, and what was waited since the last sample."""
        return max(self._device.now, self._waited_until)

    def close(self) -> None:
        """The end of the rig; may be called twice."""
        self._closed = True

    @property
    def device(self) -> Device:
        """The board and its bench, for who looks past the bytes."""
        return self._device

    def _check(self) -> Device:
        if self._closed:
            raise LinkError(f"{self.name}: the port is closed")
        self._device.check()
        return self._device


class RealTimePort(SimPort):
    """The same at the pace of the wall clock, while this process runs.

    Board and client share a process. Where the system lets it wait for a core in the middle of a
    ``read``, in which the client does nothing but listen, no time passes on the rig, or the board
    would take the computer's pause for a silent host. A client that is long about other things
    between two calls is a silent host.
    """

    def __init__(self, name: str, options: Options) -> None:
        super().__init__(name, options)
        self._began = time.monotonic()
        self._stood_still = 0.0

    def read(self, size: int, timeout_s: float) -> bytes:
        """See SimPort.read."""
        device = self._check()
        last = self.now()
        deadline = last + timeout_s
        while True:
            self._stood_still += max(self.now() - last - HICCUP_S, 0.0)
            last = self.now()
            device.advance_to(last)
            if data := device.take(size):
                return data
            device.check()
            if last >= deadline:
                return b""
            time.sleep(min(deadline - last, POLL_S))

    def write(self, data: bytes) -> None:
        """See SimPort.write."""
        self._device.advance_to(self.now())
        super().write(data)

    def now(self) -> float:
        """Seconds of the wall clock since the port was opened, less what this process missed."""
        return time.monotonic() - self._began - self._stood_still


def open_sim(url: str) -> SimPort:
    """The simulated board of a sim:// URL (see docs/simulator.md). Raises UsageError."""
    options = parse_url(url)
    kind = SimPort if options.speed == "max" else RealTimePort
    return kind(url, options)
