"""Orders by a socket: strict JSON, and clients that are slow, silent or many."""

from __future__ import annotations

import contextlib
import json
import socket
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.workflow.access import Caller
from motorid.workflow.orders import (
    MOST_CLIENTS,
    Answer,
    Message,
    Orders,
    read_order,
)
from tests.quality.controller import Controller


@given(st.binary(max_size=200))
def test_any_line_is_an_order_or_a_sentence(line: bytes) -> None:
    with contextlib.suppress(ValueError):
        assert isinstance(read_order(line + b"\n")["order"], str)


@pytest.mark.parametrize(
    "value", ["1e999", "NaN", "-Infinity", '"\\ud800"', "9" * 400, '1, "id": 2', "[" * 60_000]
)
def test_an_order_is_strict_json(value: str) -> None:
    """What is read would be answered, and an answer that is no JSON stops the controller."""
    line = f'{{"order": "status", "id": {value}}}\n'.encode()
    with pytest.raises(ValueError, match="an order is a JSON object on one line: "):
        read_order(line)


class Deaf:
    """What a socket server shows of a client that never reads."""

    def __init__(self, port: int) -> None:
        self.link = socket.socket()
        self.link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        self.link.connect(("127.0.0.1", port))

    def shout(self, lines: int) -> None:
        line = b'{"order": "status", "id": "' + b"x" * 150 + b'"}\n'
        with contextlib.suppress(OSError):  # the station ends it when enough is unread
            for _ in range(lines):
                self.link.sendall(line)


@pytest.fixture
def server() -> Iterator[Orders]:
    def take(order: Message, answer: Answer, caller: Caller) -> None:
        if order["order"] == "inspect":
            answer({"event": "accepted"})
        else:
            answer({"event": "status", "id": order.get("id"), "much": "y" * 20_000})

    orders = Orders(("127.0.0.1", 0), take)
    yield orders
    orders.stop()


def test_a_client_that_never_reads_stops_nobody(server: Orders) -> None:
    deaf = Deaf(server.port)
    deaf.shout(2_000)  # 40 MB of answers: no socket holds them
    assert Controller(server.port).ask(order="status", id=3)["id"] == 3
    deaf.link.close()


@pytest.mark.slow
def test_idle_connections_make_way_and_waiting_ones_stay(server: Orders) -> None:
    waiting = [Controller(server.port) for _ in range(3)]
    assert [one.ask(order="inspect")["event"] for one in waiting] == ["accepted"] * 3
    idle = [Controller(server.port) for _ in range(MOST_CLIENTS - 3)]
    assert {one.ask(order="status")["event"] for one in idle} == {"status"}
    late = Controller(server.port)
    assert late.ask(order="status")["event"] == "status"
    assert idle[0].file.readline() == b""  # it had said nothing for longest
    assert waiting[0].ask(order="status")["event"] == "status"
    for one in (*idle[1:], late):
        assert one.ask(order="inspect")["event"] == "accepted"
    refused = Controller(server.port)
    assert "wait already" in refused.hear()["message"]


def test_what_is_too_long_is_refused_before_it_is_kept() -> None:
    with pytest.raises(ValueError, match="'id' of an order is longer than 200 characters"):
        read_order(json.dumps({"order": "status", "id": "x" * 300}).encode() + b"\n")
