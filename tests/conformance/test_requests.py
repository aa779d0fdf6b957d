"""Request numbers: every command gets one reply, and a repeated one is not executed again."""

from __future__ import annotations

from typing import Any

import pytest

from motorid.wire.codec import encode_command
from motorid.wire.enums import State, Status
from motorid.wire.framing import encode
from tests.conformance.client import Client


def twice(client: Client, name: str, request: int, **fields: Any) -> list[bytes]:
    """The replies to one command sent twice, one after the other."""
    frame = encode(encode_command(name, request, **fields))
    first = client.exchange(frame)
    return [p for p in first + client.exchange(frame) if p[1:3] == request.to_bytes(2, "little")]


def test_a_repeated_command_gets_the_same_reply(client: Client) -> None:
    replies = twice(client, "read_status", 1000)
    assert len(replies) == 2
    assert replies[0] == replies[1]  # though time has passed


def test_a_repeated_step_is_not_loaded_twice(client: Client) -> None:
    client.configure()
    replies = twice(client, "add_step", 1000, index=0, **client.coast(10))
    assert len(replies) == 2
    assert replies[0] == replies[1]
    assert client.get("add_step", index=1, **client.coast(10))["steps"] == 2


def test_a_repeated_start_does_not_start_again(client: Client) -> None:
    hashes = client.load([client.coast(20)])
    client.told.clear()
    replies = twice(client, "start", 1000, **hashes)
    assert replies[0] == replies[1]
    client.wait(0.2)
    assert sum(message.name == "done" for message in client.told) == 1
    assert client.state is State.LOADED


def test_a_refusal_is_repeated_too(client: Client) -> None:
    client.configure()
    frame = {"index": 5, **client.coast(10)}
    assert len(set(twice(client, "add_step", 1000, **frame))) == 1


def test_a_number_once_used_is_repeated_whatever_is_asked(client: Client) -> None:
    first = client.exchange(encode(encode_command("read_status", 1000)))
    second = client.exchange(encode(encode_command("stop", 1000)))
    assert first == second


def test_only_the_last_reply_is_kept(client: Client) -> None:
    client.configure()
    step = {"index": 0, **client.coast(10)}
    assert client.ask("add_step", 1000, **step).status is Status.OK
    client.get("read_status")
    assert client.ask("add_step", 1000, **step).status is Status.BAD_VALUE  # executed again


def test_identify_is_always_answered_afresh(client: Client) -> None:
    hello = {"host_major": 1, "host_minor": 0}
    assert client.ask("identify", 1000, **hello).fields["state"] == client.state
    client.load([client.drive(1)])
    assert client.ask("identify", 1000, **hello).fields["state"] == State.LOADED
    client.configure()
    assert client.ask("identify", 1000, **hello).fields["state"] == State.CONFIGURED
    assert client.ask("identify", 1000, **hello).fields["state"] == State.CONFIGURED


def test_the_highest_numbers_are_numbers_like_others(client: Client) -> None:
    for request in (0x00FF, 0x0100, 0xFFFE, 0xFFFF, 1):
        assert client.ask("read_status", request).request == request


@pytest.mark.needs("reset")
def test_after_a_reset_no_reply_is_kept(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    client.ask("configure", 1000, **client.settings)
    board.reset(1)
    client.wait(0.1)
    assert client.ask("add_step", 1000, index=0, **client.coast(1)).status == Status.NOT_CONFIGURED
