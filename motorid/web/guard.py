"""Whom a page answers: a request with the token, for this host, and from its own page."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

from motorid.web.address import Address
from motorid.workflow.access import Caller

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]
HTTP, SOCKET, LIFESPAN = "http", "websocket", "lifespan"
CALLER = "motorid caller"  # in the scope that a page's own code sees
REFUSED = 1008  # a websocket's code of a broken rule
WORDS = (
    b"motorid shows this page to who opens its whole address, with the token, as the program "
    b"printed it.\n"
)
HEADERS = {
    b"content-security-policy": b"default-src 'none'; script-src 'self'; style-src 'self'; "
    b"connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; "
    b"frame-ancestors 'none'",
    b"x-content-type-options": b"nosniff",
    b"x-frame-options": b"DENY",
    b"referrer-policy": b"no-referrer",
    b"cross-origin-opener-policy": b"same-origin",
    b"cross-origin-resource-policy": b"same-origin",
    b"cache-control": b"no-store",
}


class Guard:
    """Stands before ``app``, which sees only what is admitted, with the token cut off its path."""

    def __init__(self, app: App, address: Address) -> None:
        self.app, self.address = app, address

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request, as ASGI has it."""
        if scope["type"] == LIFESPAN:
            await self.app(scope, receive, send)
            return
        admitted = self._admitted(scope)
        if admitted is None:
            await _refuse(scope, receive, send)
            return
        path, caller = admitted
        inner = {**scope, "path": path, "raw_path": path.encode(), "root_path": "", CALLER: caller}

        async def sealed(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                own = list(message.get("headers", ()))
                said = {name for name, _ in own}  # a page that says its own policy keeps it
                message["headers"] = [*own, *(one for one in HEADERS.items() if one[0] not in said)]
            await send(message)

        await self.app(inner, receive, sealed if scope["type"] == HTTP else send)

    def _admitted(self, scope: Scope) -> tuple[str, Caller] | None:
        """The path after the token, and whose it is; None where the request is not admitted."""
        hosts, origins = _values(scope, b"host"), _values(scope, b"origin")
        if len(hosts) != 1 or not self.address.admits_host(_name(hosts[0])):
            return None
        own = [f"{self.address.scheme}://{hosts[0]}"]
        if origins != own and (origins or scope["type"] == SOCKET):
            return None  # a browser names the page that opens a socket: it must be ours
        token, slash, rest = scope["path"].removeprefix("/").partition("/")
        caller = self.address.caller(token)
        if caller is None or not slash:
            return None
        return f"/{rest}", caller


def _values(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1").lower() for key, value in scope["headers"] if key == name]


def _name(host: str) -> str:
    """The name in a Host header, without its port; "" where it is none."""
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


async def _refuse(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == SOCKET:
        await receive()
        await send({"type": "websocket.close", "code": REFUSED})
        return
    length = (b"content-length", str(len(WORDS)).encode())
    kind = (b"content-type", b"text/plain; charset=utf-8")
    headers = [length, kind, *HEADERS.items()]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": WORDS})
