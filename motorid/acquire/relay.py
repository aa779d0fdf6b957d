"""relay://?…&to=PORT: any port, with a bad cable before it, by a seed."""

from __future__ import annotations

from collections.abc import Callable
from urllib.parse import parse_qsl

from motorid.acquire.link import Port
from motorid.errors import LinkError, UsageError
from motorid.sim.faults import KINDS, PASSING, Fault, Kind, parse_faults
from motorid.sim.link import Cable

RELAY_KINDS = {name: KINDS[name] for name in (*PASSING, "unplug")} | {
    "reset": Kind(None, "the port is closed and opened again, which resets many boards"),
    "swap": Kind(
        0.1, "unplugged for so many seconds, and then another board is there: the port `other`"
    ),
}
CHUNK = 4096
GLANCE_S = 1e-3  # the shortest wait, so that a port's own rounding cannot hold time still


class RelayPort:
    """A port whose bytes pass a faulty cable, both ways, on the inner port's clock.

    ``open_again`` opens what a ``reset`` or ``swap`` puts in the inner port's place. Fault times
    count from now.
    """

    def __init__(
        self,
        inner: Port,
        faults: tuple[Fault, ...] = (),
        seed: int = 1,
        open_again: Callable[[str], Port] | None = None,
    ) -> None:
        self.name = inner.name
        self.cable = Cable(0, seed)
        self._inner = inner
        self._open_again = open_again
        self._shift_s = 0.0  # the inner ports' clocks, joined into one
        began = inner.now()
        plan = [(began + (f.at_s or 0.0), f, True) for f in faults]
        plan += [(began + f.until_s, f, False) for f in faults if f.until_s is not None]
        self._plan = sorted(plan, key=lambda item: item[0])
        self._act()

    def read(self, size: int, timeout_s: float) -> bytes:
        """See Port."""
        until = self.now() + timeout_s
        while True:
            self._act()
            now = self.now()
            if data := self.cable.take(size, now):
                return data
            if now >= until:
                return b""
            wait = max(min(until, self._next_event()) - now, GLANCE_S)
            self.cable.up.send(self._inner.read(CHUNK, wait), self.now())

    def write(self, data: bytes) -> None:
        """See Port."""
        self._act()
        self.cable.down.send(data, self.now())
        self._act()

    def now(self) -> float:
        """See Port: goes on across a swap."""
        return self._inner.now() + self._shift_s

    def close(self) -> None:
        """See Port."""
        self._inner.close()

    def _next_event(self) -> float:
        """When a fault, or a byte on its way, is due."""
        fault = self._plan[0][0] if self._plan else float("inf")
        return min(fault, self.cable.up.due, self.cable.down.due)

    def _act(self) -> None:
        """Lets everything happen that is due. Raises LinkError while no board is there."""
        while self._plan and self._plan[0][0] <= self.now():
            _, fault, on = self._plan.pop(0)
            self._strike(fault, on)
        if self.cable.unplugged:
            raise LinkError(f"{self.name}: the relay pulled the cable (a fault asked for)")
        while data := self.cable.down.take(CHUNK, self.now()):
            self._inner.write(data)

    def _strike(self, fault: Fault, on: bool) -> None:
        match fault.name:
            case "reset":
                self._replace("to")
            case "swap":
                self.cable.apply(Fault("silence", 0, None))
                self._plan.append((self.now() + fault.value, Fault("plug", 0, None), True))
                self._plan.sort(key=lambda item: item[0])
            case "plug":
                self._replace("other")
                self.cable.apply(Fault("silence", 0, None), on=False)
            case _:
                self.cable.apply(fault, on)

    def _replace(self, which: str) -> None:
        """Another board, or the same one reset, in the inner port's place."""
        now = self.now()
        self._inner.close()
        if self._open_again is None:
            raise LinkError(f"{self.name}: the relay has nothing to plug in")
        self._inner = self._open_again(which)
        self._shift_s = now - self._inner.now()


def open_relay(url: str, open_port: Callable[[str], Port]) -> RelayPort:
    """The port of a relay:// URL (see docs/simulator.md). Raises UsageError or LinkError.

    ``open_port`` opens the ports that stand behind it.
    """
    head, found, to = url.partition("to=")
    query = head.removeprefix("relay://").removeprefix("?").removesuffix("&")
    if not found or not to or not head.endswith(("?", "&")):
        raise UsageError(f"port {url}: write relay://?fault=…&to=PORT, with to last")
    options = {"seed": "1", "fault": "", "other": to}
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name not in options:
            raise UsageError(f"port {url}: unknown option {name}; known: {', '.join(options)}, to")
        options[name] = value
    if not options["seed"].isdecimal():
        raise UsageError(f"port {url}: seed must be a whole number, not {options['seed']!r}")
    faults = parse_faults(options["fault"], RELAY_KINDS)
    urls = {"to": to, "other": options["other"]}
    return RelayPort(
        open_port(to), faults, int(options["seed"]), lambda which: open_port(urls[which])
    )
