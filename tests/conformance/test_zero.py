"""zero: offsets and noise at standstill."""

from __future__ import annotations

from typing import Any

import pytest

from motorid.wire.enums import Channel, State, Status
from motorid.wire.spec import REPLY_BIT, load
from tests.conformance.client import Client

ZERO_REPLY = load().commands["zero"].code | REPLY_BIT


def test_zero_measures_offset_and_noise(client: Client) -> None:
    client.configure()
    fields = client.await_reply(client.send("zero", samples=1000), 2.0).fields
    for name, channel in (("current", Channel.CURRENT), ("voltage", Channel.TERMINAL_VOLTAGE)):
        fact = client.descriptors[channel]
        spread = 6 * fact["offset_uncertainty"] + 1
        assert abs(fields[f"{name}_offset"] - fact["offset"]) <= spread
        assert fields[f"{name}_noise"] <= 2 * fact["noise"] + 1


def test_zero_answers_when_its_readings_are_taken(client: Client) -> None:
    client.configure()
    began = client.port.now()
    client.await_reply(client.send("zero", samples=2000), 2.0)
    elapsed = client.port.now() - began
    assert client.seconds(2000) * 0.95 < elapsed < client.seconds(2000) + 0.25


def test_one_reading_has_no_noise(client: Client) -> None:
    client.configure()
    fields = client.get("zero", samples=1)
    assert fields["current_noise"] == fields["voltage_noise"] == 0
    assert fields["current_offset"] == round(fields["current_offset"])


@pytest.mark.parametrize("samples", [0, 4097, 65535])
def test_a_senseless_number_of_readings_is_refused(client: Client, samples: int) -> None:
    client.configure()
    assert client.ask("zero", samples=samples).status is Status.BAD_VALUE
    assert client.state is State.CONFIGURED


def test_the_most_readings(client: Client) -> None:
    client.configure()
    assert client.await_reply(client.send("zero", samples=4096), 3.0).status is Status.OK


def test_zero_refuses_a_motor_that_turns(client: Client) -> None:
    client.run(client.drive(800))  # and coasts on
    reply = client.await_reply(client.send("zero", samples=1000), 2.0)
    assert reply.status is Status.NOT_AT_REST
    assert client.state is State.LOADED


def test_stop_ends_it_and_both_are_answered(client: Client) -> None:
    client.configure()
    zero = client.send("zero", samples=4096)
    client.wait(0.02)
    assert client.state is State.ZEROING
    stop = client.send("stop")
    assert client.await_reply(zero).status is Status.BAD_STATE
    reply = client.await_reply(stop)
    assert (reply.status, reply.fields) == (Status.OK, {"state": State.CONFIGURED})


def test_repeating_it_while_it_measures_is_not_answered_apart(client: Client) -> None:
    client.configure()
    request = client.send("zero", samples=1000)
    client.payloads.clear()
    for _ in range(3):
        client.wait(0.01)
        client.send("zero", request, samples=1000)
    client.wait(0.5 + client.seconds(1000))
    assert [payload[0] for payload in client.payloads].count(ZERO_REPLY) == 1
    client.send("zero", request, samples=1000)
    client.wait(0.1)
    answers = [payload for payload in client.payloads if payload[0] == ZERO_REPLY]
    assert len(answers) == 2
    assert answers[0] == answers[1]


def test_zero_subtracts_nothing(client: Client) -> None:
    client.configure()
    offset: Any = client.get("zero", samples=500)["current_offset"]
    samples = client.run(client.coast(100)).channel(Channel.CURRENT)
    assert (
        abs(float(samples.mean()) - offset) < 2 * client.descriptors[Channel.CURRENT]["noise"] + 1
    )
