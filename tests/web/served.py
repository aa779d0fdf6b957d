"""A live page on loopback, fed by a test or by a simulated rig."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from motorid.acquire.controls import Controls
from motorid.acquire.interrupt import Stop
from motorid.acquire.port import open_port
from motorid.acquire.safety import check_program
from motorid.acquire.scope import Scope
from motorid.acquire.tap import Tap
from motorid.rig import Rig
from motorid.web.address import parse_listen
from motorid.web.hub import Hub
from motorid.web.live import Desk, live_app
from motorid.web.server import Server


@dataclass(frozen=True)
class Served:
    """What a page is fed by, and where it is."""

    tap: Tap
    hub: Hub
    url: str

    @property
    def socket(self) -> str:
        """The address of its websocket."""
        return self.url.replace("http", "ws") + "live"

    @property
    def origin(self) -> str:
        """What a browser says that its page's socket comes from."""
        return "/".join(self.url.split("/")[:3])


@contextlib.contextmanager
def served(desk: Desk | None = None, **facts: Any) -> Iterator[Served]:
    tap = Tap()
    drive = {"silence_s": desk.silence_s, "program_s": 1.0} if desk else None
    hub = Hub(tap, {"rig": "bench", "command": "scope", "drive": drive, **facts})
    with Server(lambda: live_app(hub, desk), parse_listen("0")) as server:
        yield Served(tap, hub, server.url)


@contextlib.contextmanager
def scope(rig: Rig, said: list[tuple[str, str]]) -> Iterator[Served]:
    """A scope that a page may drive; ``said`` gets its states and sentences."""
    controls, stop = Controls(), Stop()
    desk = Desk(controls, rig.program, rig.limits.host_silence_s, lambda p: check_program(rig, p))
    with served(desk) as here, contextlib.closing(open_port(rig.port)) as port:

        def say(state: str, text: str) -> None:
            said.append((state, text))
            here.hub.post(state=state, text=text, said=len(said))

        watched = Scope(port, rig, here.tap.begin, controls, say)
        thread = threading.Thread(target=watched.run, args=(stop,))
        thread.start()
        try:
            yield here
        finally:
            stop.requested = True
            thread.join()
