"""The live page: samples as they come, and with leave the buttons that drive."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Callable
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any

from motorid import json_text
from motorid.acquire.controls import Controls, Press
from motorid.errors import MotoridError, UsageError
from motorid.program import Decay, Program, Step, StepKind
from motorid.web.guard import App
from motorid.web.hub import Hub, Viewer
from motorid.web.server import beside

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.websockets import WebSocket

TRY_LATER = 1013  # a websocket's code: there are too many
BROKEN = 1008
KINDS = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
    "svg": "image/svg+xml",
}
FILES = (
    "live.html", "live.css", "live.js", "store.js", "trigger.js", "strips.js", "readout.js",
    "drive.js", "link.js", "icon.svg", "uPlot.iife.min.js", "uPlot.min.css",
)  # fmt: skip
Check = Callable[[Program], None]  # raises what is wrong with a program


class Desk:
    """What a page may ask where driving is allowed: the rig's program, a pulse, a stop."""

    def __init__(
        self, controls: Controls, program: Program, silence_s: float, check: Check
    ) -> None:
        self.controls, self.program = controls, program
        self.silence_s, self.check = silence_s, check

    def press(self, asked: dict[str, Any]) -> Press:
        """The press that a page asked for, on the desk. Raises MotoridError where it may not be."""
        program = self.program if asked.get("what") == "program" else _pulse(asked)
        self.check(program)
        press = Press(program, self.silence_s)
        if refusal := self.controls.offer(press):
            raise UsageError(refusal)
        return press


def _pulse(asked: dict[str, Any]) -> Program:
    numbers = []
    for name in ("volts", "seconds"):
        value = asked.get(name)
        good = isinstance(value, int | float) and not isinstance(value, bool)
        if not good or not math.isfinite(float(value or 0)):
            raise UsageError(f"a pulse needs {name}, a number")
        numbers.append(float(value or 0))
    volts, seconds = numbers
    if not seconds > 0:
        raise UsageError("a pulse lasts longer than 0 s")
    drive = Step(StepKind.DRIVE_VOLTS, seconds, volts, Decay.SYNCHRONOUS_SLOW)
    return Program((drive, Step(StepKind.COAST, 1.0)))


def live_app(hub: Hub, desk: Desk | None = None) -> App:
    """The page of ``hub``. Without a ``desk`` it only watches."""
    from starlette.applications import Starlette
    from starlette.routing import Route, WebSocketRoute

    async def talk(socket: WebSocket) -> None:
        await _talk(socket, hub, desk)

    routes = [
        Route("/", _file, methods=["GET"]),
        Route("/{name}", _file, methods=["GET"]),
        WebSocketRoute("/live", talk),
    ]
    app: App = Starlette(routes=routes, lifespan=beside(hub.pump))  # type: ignore[arg-type]
    return app


async def _file(request: Request) -> Response:
    from starlette.responses import Response

    name = request.path_params.get("name", FILES[0])
    if name not in FILES:
        return Response("there is no such page\n", 404, media_type="text/plain")
    return Response(_content(name), media_type=KINDS[name.rpartition(".")[2]])


@cache
def _content(name: str) -> bytes:
    return resources.files("motorid.web").joinpath("page", name).read_bytes()


async def _talk(socket: WebSocket, hub: Hub, desk: Desk | None) -> None:
    """One page, for as long as it is there. What it pressed ends with it."""
    viewer = Viewer()
    await socket.accept()
    if not hub.join(viewer):
        await socket.close(TRY_LATER, "too many pages watch already")
        return
    tasks = [
        asyncio.ensure_future(one) for one in (_show(socket, viewer), _hear(socket, viewer, desk))
    ]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        hub.viewers.discard(viewer)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        with contextlib.suppress(RuntimeError):  # it is closed already
            await socket.close()


async def _show(socket: WebSocket, viewer: Viewer) -> None:
    while True:
        news = await viewer.next()
        await (socket.send_text(news) if isinstance(news, str) else socket.send_bytes(news))


async def _hear(socket: WebSocket, viewer: Viewer, desk: Desk | None) -> None:
    """What the page says, until it goes or says what no page of ours does."""
    from starlette.websockets import WebSocketDisconnect

    press: Press | None = None
    try:
        while True:
            asked = _order(await socket.receive_text())
            if asked is None or desk is None:
                await socket.close(BROKEN, "this page only watches")
                return
            try:
                press = _obey(asked, desk, press)
            except MotoridError as error:
                viewer.answer(json_text.dumps({"refused": str(error)}))
    except (WebSocketDisconnect, KeyError, RuntimeError):
        return  # it has gone, or sent bytes
    finally:
        if press is not None:
            press.stop("the page has gone")


def _order(text: str) -> dict[str, Any] | None:
    try:
        asked = json_text.loads(text)
    except json_text.JsonError:
        return None
    return asked if isinstance(asked, dict) else None


def _obey(asked: dict[str, Any], desk: Desk, press: Press | None) -> Press | None:
    """Carries out one order; the page's press from then on."""
    match asked.get("ask"):
        case "beat":
            if press is not None:
                press.hear()
        case "stop":
            desk.controls.stop("the page asked for it")
        case "press":
            return desk.press(asked)
    return press
