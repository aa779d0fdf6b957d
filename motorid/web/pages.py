"""What all pages share: their files, and one websocket a page for frames, texts and orders."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, Any, Protocol

from motorid import json_text
from motorid.errors import MotoridError
from motorid.web.guard import CALLER, App
from motorid.web.hub import Hub, Viewer
from motorid.web.server import beside
from motorid.workflow.access import Caller

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
    "drive.js", "link.js", "station.html", "station.css", "station.js", "words.js", "sound.js",
    "keys.js", "theme.css", "icon.svg", "uPlot.iife.min.js", "uPlot.min.css",
)  # fmt: skip


class Talker(Protocol):
    """What hears one page, for as long as it is there."""

    def hear(self, asked: dict[str, Any]) -> None:
        """One order of the page. Raises MotoridError, whose sentence the page is shown."""

    def gone(self) -> None:
        """The page is closed."""


def app_of(hub: Hub, start: str, talker: Callable[[Caller], Talker] | None) -> App:
    """The page ``start`` of ``hub``. Without a ``talker`` it only watches."""
    from starlette.applications import Starlette
    from starlette.routing import Route, WebSocketRoute

    async def talk(socket: WebSocket) -> None:
        await _talk(socket, hub, talker(socket.scope[CALLER]) if talker is not None else None)

    async def file(request: Request) -> Response:
        return _file(request.path_params.get("name", start))

    routes = [
        Route("/", file, methods=["GET"]),
        Route("/{name}", file, methods=["GET"]),
        WebSocketRoute("/live", talk),
    ]
    app: App = Starlette(routes=routes, lifespan=beside(hub.pump))  # type: ignore[arg-type]
    return app


def _file(name: str) -> Response:
    from starlette.responses import Response

    if name not in FILES:
        return Response("there is no such page\n", 404, media_type="text/plain")
    return Response(_content(name), media_type=KINDS[name.rpartition(".")[2]])


@cache
def _content(name: str) -> bytes:
    return resources.files("motorid.web").joinpath("page", name).read_bytes()


async def _talk(socket: WebSocket, hub: Hub, talker: Talker | None) -> None:
    """One page, for as long as it is there."""
    viewer = Viewer()
    await socket.accept()
    if not hub.join(viewer):
        await socket.close(TRY_LATER, "too many pages watch already")
        return
    work = (_show(socket, viewer), _hear(socket, viewer, talker))
    tasks = [asyncio.ensure_future(one) for one in work]
    try:
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    finally:
        hub.viewers.discard(viewer)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if talker is not None:
            talker.gone()
        with contextlib.suppress(RuntimeError):  # it is closed already
            await socket.close()


async def _show(socket: WebSocket, viewer: Viewer) -> None:
    while True:
        news = await viewer.next()
        await (socket.send_text(news) if isinstance(news, str) else socket.send_bytes(news))


async def _hear(socket: WebSocket, viewer: Viewer, talker: Talker | None) -> None:
    """What the page says, until it goes or says what no page of ours does."""
    from starlette.websockets import WebSocketDisconnect

    try:
        while True:
            asked = _order(await socket.receive_text())
            if asked is None or talker is None:
                await socket.close(BROKEN, "this page only watches")
                return
            try:
                talker.hear(asked)
            except MotoridError as error:
                viewer.answer(json_text.dumps({"refused": str(error)}))
    except (WebSocketDisconnect, KeyError, RuntimeError):
        return  # it has gone, or sent bytes


def _order(text: str) -> dict[str, Any] | None:
    try:
        asked = json_text.loads(text)
    except json_text.JsonError:
        return None
    return asked if isinstance(asked, dict) else None
