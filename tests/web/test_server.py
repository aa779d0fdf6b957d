"""The server behind the page: what it serves, what it lets a page do, and whom it waits for."""

from __future__ import annotations

import http.client
import json
import ssl
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from motorid.acquire.scope import DONE, DRIVING, STOPPED, WATCHING
from motorid.errors import UsageError
from motorid.program import Decay, Program, Step, StepKind
from motorid.web.address import parse_listen
from motorid.web.hub import MOST_WAITING, Hub
from motorid.web.live import live_app
from motorid.web.pages import FILES
from motorid.web.server import Server
from tests.acquire.rigs import sim_rig
from tests.acquire.test_strips import FACTS, Tap, block
from tests.certificates import pair
from tests.web.served import Served, scope, served

PATIENCE_S = 60.0
LONG = Program((Step(StepKind.DRIVE_VOLTS, 15.0, 2.0, Decay.SYNCHRONOUS_SLOW),))


def until(what: Callable[[], object]) -> None:
    end = time.monotonic() + PATIENCE_S
    while not what():
        assert time.monotonic() < end
        time.sleep(0.01)


def get(url: str, path: str = "", context: ssl.SSLContext | None = None) -> tuple[int, bytes]:
    parts = urlsplit(url)
    assert parts.hostname
    if context:
        link: http.client.HTTPConnection = http.client.HTTPSConnection(
            parts.hostname, parts.port, context=context, timeout=PATIENCE_S
        )
    else:
        link = http.client.HTTPConnection(parts.hostname, parts.port, timeout=PATIENCE_S)
    link.request("GET", parts.path + path)
    reply = link.getresponse()
    return reply.status, reply.read()


def page(here: Served) -> ClientConnection:
    return connect(here.socket, origin=here.origin, close_timeout=1)  # type: ignore[arg-type]


@pytest.mark.slow
def test_it_serves_its_files_to_who_has_the_token_and_nothing_else() -> None:
    with served() as here:
        for name in FILES:
            status, body = get(here.url, name)
            assert (status, bool(body)) == (200, True), name
        assert get(here.url)[1] == get(here.url, "live.html")[1]
        for name in ("server.py", "../server.py", "%2e%2e/server.py", "uPlot.LICENSE"):
            assert get(here.url, name)[0] == 404, name
        assert get(here.origin)[0] == 403
        with pytest.raises(InvalidStatus):
            connect(here.socket, open_timeout=PATIENCE_S)  # no page of ours asks so


@pytest.mark.slow
def test_its_address_is_taken_only_once() -> None:
    with served() as here:
        port = urlsplit(here.url).port
        with pytest.raises(UsageError, match="--listen"):
            Server(lambda: live_app(Hub(Tap(), {})), parse_listen(str(port)))


@pytest.mark.slow
def test_it_speaks_tls(tmp_path: Path) -> None:
    cert, key = pair(tmp_path)
    address = parse_listen("0", certificate=cert, key=key)
    with Server(lambda: live_app(Hub(Tap(), {})), address) as server:
        trusting = ssl.create_default_context(cafile=cert)
        trusting.check_hostname = False
        assert get(server.url, "live.js", trusting)[0] == 200


@pytest.mark.slow
@pytest.mark.parametrize("asked", ['{"ask": "press", "what": "program"}', "{", "[]", "x" * 5000])
def test_a_page_that_only_watches_is_told_nothing_it_could_drive_by(asked: str) -> None:
    """Whoever asks for more than that is no page of ours."""
    with served() as here, page(here) as socket:
        assert json.loads(socket.recv())["drive"] is None
        socket.send(asked)
        with pytest.raises(ConnectionClosed):
            socket.recv(timeout=PATIENCE_S)


@pytest.mark.slow
def test_a_client_that_does_not_read_costs_others_nothing() -> None:
    """Far more than any socket holds."""
    samples = [512] * 20_000
    with served() as here, page(here) as asleep:
        assert asleep
        until(lambda: here.hub.viewers)
        give, (viewer,) = here.tap.begin(FACTS), here.hub.viewers
        for number in range(MOST_WAITING + 50):
            give(block(250 * len(samples) * number, samples, samples))
            until(lambda: not here.tap.waiting)  # a frame for each
        assert here.tap.lost == 0
        assert len(viewer._frames) <= MOST_WAITING
        with page(here) as awake:
            assert json.loads(awake.recv(timeout=PATIENCE_S))["rig"] == "bench"
            assert isinstance(awake.recv(timeout=PATIENCE_S), bytes)


def said_so_far(said: list[tuple[str, str]]) -> list[str]:
    return [state for state, _ in said]


@pytest.mark.slow
def test_a_press_whose_page_goes_is_stopped() -> None:
    rig, said = sim_rig(speed="realtime"), list[tuple[str, str]]()
    rig = replace(rig, limits=replace(rig.limits, host_silence_s=2.0))
    with scope(replace(rig, program=LONG), said) as here:
        with page(here) as socket:
            socket.send('{"ask": "press", "what": "pulse", "volts": 99, "seconds": 1}')
            texts = (t for t in socket if isinstance(t, str))
            assert "99 V" in next(t for t in texts if "refused" in t)
            socket.send('{"ask": "press", "what": "program"}')
            until(lambda: DRIVING in said_so_far(said))
        until(lambda: said[-1][0] == WATCHING and STOPPED in said_so_far(said))
    assert ("stopped", "stopped: the page has gone") in said


@pytest.mark.slow
def test_a_press_whose_page_is_silent_is_stopped() -> None:
    """The page is there, and its socket open; it says nothing."""
    rig, said = sim_rig(speed="realtime"), list[tuple[str, str]]()
    with scope(replace(rig, program=LONG), said) as here, page(here) as socket:
        socket.send('{"ask": "press", "what": "program"}')
        until(lambda: STOPPED in said_so_far(said))
    assert ("stopped", "stopped: the page was silent for 0.5 s") in said
    assert DONE not in said_so_far(said)
