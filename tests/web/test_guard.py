"""Whom the server of a page answers, and where it listens."""

from __future__ import annotations

import asyncio
from collections.abc import MutableMapping
from pathlib import Path
from typing import Any

import pytest

from motorid.errors import UsageError
from motorid.web.address import Address, parse_listen
from motorid.web.guard import Guard
from tests.certificates import pair

TOKEN = "right-token"
HOST = "127.0.0.1:7411"
HERE = Address("127.0.0.1", 7411, token=TOKEN)
Message = MutableMapping[str, Any]


def answer(
    address: Address = HERE,
    *,
    kind: str = "http",
    path: str = f"/{TOKEN}/x",
    host: str | None = HOST,
    origin: str | None = None,
    more: tuple[tuple[bytes, bytes], ...] = (),
) -> tuple[str, list[Message]]:
    """The path that the page's own code saw ("" where it was not asked), and what was sent."""
    seen: list[str] = []
    sent: list[Message] = []

    async def app(scope: Message, receive: Any, send: Any) -> None:
        seen.append(scope["path"])
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive() -> Message:
        return {"type": f"{kind}.connect"}

    async def send(message: Message) -> None:
        sent.append(message)

    named = [(b"host", host), (b"origin", origin)]
    headers = [(name, value.encode()) for name, value in named if value is not None]
    scope = {"type": kind, "path": path, "headers": [*headers, *more]}
    asyncio.run(Guard(app, address)(scope, receive, send))
    return (seen or [""])[0], sent


def test_the_token_opens_the_page_and_is_cut_off() -> None:
    path, sent = answer()
    assert path == "/x"
    headers = dict(sent[0]["headers"])
    assert b"default-src 'none'" in headers[b"content-security-policy"]
    assert headers[b"referrer-policy"] == b"no-referrer"  # the token is in the address


@pytest.mark.parametrize(
    "asked",
    [
        {"path": "/"},
        {"path": f"/{TOKEN}"},
        {"path": "/wrong/x"},
        {"path": f"/{TOKEN}x/x"},
        {"path": "//x"},
        {"path": "/\u1234/x"},
        {"host": None},
        {"host": "evil.example:7411"},
        {"host": "192.0.2.1:7411"},
        {"host": "[::"},
        {"host": ""},
        {"more": ((b"host", HOST.encode()),)},
        {"origin": "http://evil.example"},
        {"origin": "http://127.0.0.1:8000"},
        {"origin": f"https://{HOST}"},
        {"origin": "null"},
        {"kind": "websocket"},  # without its page's origin
        {"kind": "websocket", "origin": "http://localhost:7411"},
    ],
    ids=str,
)
def test_others_are_refused(asked: dict[str, Any]) -> None:
    path, sent = answer(**asked)
    assert path == ""
    if asked.get("kind"):
        assert sent == [{"type": "websocket.close", "code": 1008}]
    else:
        assert sent[0]["status"] == 403
        assert TOKEN.encode() not in sent[1]["body"]


@pytest.mark.parametrize("host", [HOST, "localhost:7411", "[::1]:7411", "localhost:8000"])
def test_its_own_page_may_open_a_socket(host: str) -> None:
    """Through a tunnel too, whose port is another."""
    path, _ = answer(kind="websocket", host=host, origin=f"http://{host}")
    assert path == "/x"


def test_each_start_has_its_own_token() -> None:
    tokens = {parse_listen("0").token for _ in range(8)}
    assert len(tokens) == 8
    assert all(len(token) >= 32 for token in tokens)


@pytest.mark.parametrize(
    ("text", "remote", "why"),
    [
        ("x", False, "write PORT"),
        ("70000", False, "write PORT"),
        ("²", False, "write PORT"),
        ("host:7411", False, "an IP address"),
        ("0.0.0.0:7411", False, "--allow-remote"),
        ("192.0.2.1:7411", True, "TLS"),
        ("[::]:7411", True, "TLS"),
    ],
)
def test_an_address_that_may_not_be(text: str, remote: bool, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        parse_listen(text, remote=remote)


def test_a_port_alone_is_loopback() -> None:
    one = parse_listen("7500")
    assert (one.host, one.port, one.scheme, one.loopback) == ("127.0.0.1", 7500, "http", True)
    assert one.url(7500) == f"http://127.0.0.1:7500/{one.token}/"


def test_beyond_this_computer_it_takes_tls(tmp_path: Path) -> None:
    cert, key = pair(tmp_path)
    one = parse_listen("0.0.0.0:7411", remote=True, certificate=cert, key=key)
    assert one.url(7411).startswith("https://")
    assert not one.url(7411).startswith("https://0.")
    assert one.admits_host("192.0.2.1")  # any address is its own; a foreign name is not
    assert not one.admits_host("evil.example")


@pytest.mark.parametrize("spoilt", ["absent", "swapped", "password", "no key"])
def test_a_certificate_that_does_not_serve(spoilt: str, tmp_path: Path) -> None:
    cert, key = pair(tmp_path, password=b"secret" if spoilt == "password" else b"")
    pairs: dict[str, tuple[Path, Path | None]] = {
        "absent": (tmp_path / "none.pem", key),
        "swapped": (key, cert),
        "no key": (cert, None),
    }
    one, other = pairs.get(spoilt, (cert, key))
    with pytest.raises(UsageError, match="key"):
        parse_listen("7411", certificate=one, key=other)
