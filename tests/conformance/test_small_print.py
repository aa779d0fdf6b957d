"""What the protocol settles in half a sentence, where two boards might well differ."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motorid.wire.codec import encode_command
from motorid.wire.enums import Channel, ChannelKind, Decay, Fault, ResetCause, Status
from motorid.wire.framing import DELIMITER, encode
from motorid.wire.spec import REPLY_BIT, load
from tests.conformance.client import Client
from tests.conformance.test_link import raw_frame
from tests.conformance.test_trips import half_speed

SPEC = load()
IDENTIFY = SPEC.commands["identify"].code
CONFIGURE = SPEC.commands["configure"].code
MEAN_V = 0.1  # of the supply: resistance and dead time of the bridge


@pytest.mark.needs("reset")
def test_a_delimiter_goes_before_hello(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    heard = bytearray()
    read = client.port.read
    board.reset(int(ResetCause.EXTERNAL))
    for _ in range(20):
        heard += read(4096, 0.01)
    assert heard[:1] == DELIMITER
    assert heard[1] != 0


@pytest.mark.parametrize(
    "again",
    [
        encode_command("heartbeat", 50, sequence=1),
        bytes([0x3F, 50, 0]),
        bytes([CONFIGURE, 50, 0, 1]),
    ],
    ids=["another command", "an unknown one", "one cut short"],
)
def test_the_kept_reply_answers_whatever_repeats_its_number(client: Client, again: bytes) -> None:
    first = client.exchange(encode(encode_command("describe_channel", 50, index=0)))
    assert client.exchange(raw_frame(again)) == first
    assert len(first) == 1


def test_a_refusal_is_kept_too(client: Client) -> None:
    refusal = client.exchange(raw_frame(bytes([CONFIGURE, 51, 0, 1])))
    assert refusal == [bytes([CONFIGURE | REPLY_BIT, 51, 0, Status.BAD_LENGTH])]
    assert client.exchange(encode(encode_command("read_status", 51))) == refusal


def test_identify_cut_short_names_no_major(client: Client) -> None:
    """Neither when it names another major, nor after one that was executed."""
    short = raw_frame(bytes([IDENTIFY, 60, 0, SPEC.major + 1]))
    refused = [bytes([IDENTIFY | REPLY_BIT, 60, 0, Status.BAD_LENGTH])]
    assert client.exchange(short) == refused
    assert client.ask("heartbeat", sequence=0).status is Status.OK
    client.get("identify", host_major=SPEC.major + 1, host_minor=0)
    assert client.exchange(short) == refused
    assert client.ask("heartbeat", sequence=0).status is Status.MAJOR_MISMATCH
    client.get("identify", host_major=SPEC.major, host_minor=0)


@pytest.mark.parametrize("reversed_", [0, 1])
def test_over_speed_has_the_sign_of_the_position(client: Client, reversed_: int) -> None:
    limit = half_speed(client)
    client.configure(encoder_reversed=reversed_)
    record = client.run(client.drive(4000), speed_limit_counts_s=limit)
    (event,) = record.all("fault")
    assert event["fault"] == Fault.OVER_SPEED
    assert (event["value"] < 0) == bool(reversed_)
    moved = np.diff(record.channel(Channel.POSITION).view("u2").astype(np.uint16)).view("i2")
    assert int(moved[-20:].sum()) * event["value"] > 0


@pytest.mark.parametrize("decay", [Decay.SYNCHRONOUS_SLOW, Decay.FAST])
@pytest.mark.parametrize("duty", [0.4, -0.3])
def test_duty_times_supply_is_the_mean_voltage(
    make_client: Callable[..., Client], decay: Decay, duty: float
) -> None:
    client = make_client()
    step = client.drive(400, duty) | {"decay": decay}
    if not client.identity["decay_modes"] >> decay & 1:
        client.configure()
        assert client.ask("add_step", index=0, **step).status is Status.NOT_SUPPORTED
        return
    assert client.descriptors[Channel.TERMINAL_VOLTAGE]["kind"] == ChannelKind.MEAN
    record = client.run(step)
    volts, supply = (
        client.value(channel, float(record.channel(channel)[200:].mean()))
        for channel in (Channel.TERMINAL_VOLTAGE, Channel.SUPPLY_VOLTAGE)
    )
    assert abs(volts - duty * supply) < MEAN_V * supply
