"""What minor 3 added: a voltage ceiling, contacts, a sign check; and hosts of older minors."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import Any

import pytest

from motorid.wire.codec import encode_command
from motorid.wire.enums import Channel, Fault, Feature, Input, ResetCause, Status
from motorid.wire.framing import encode
from motorid.wire.spec import COMMAND_HEADER, REPLY_HEADER, load, required_size
from tests.conformance.client import Client, Fields

CONFIGURE = load().commands["configure"]
OLD = required_size(CONFIGURE.fields)
LACKS = "no device: it says that it lacks this feature"


def signs(client: Client, **changes: int) -> Fields:
    """A sign check that a healthy bench passes: a tenth of what it measures, and few counts."""
    supply = client.settings["supply_max_mv"] // 1.5
    most = client.identity["max_current_ma"]
    checked = {"sign_check_ma": most // 10, "sign_check_mv": supply // 10, "sign_check_counts": 4}
    return {"sign_check_ms": 200, **{k: int(v) for k, v in checked.items()}, **changes}


def test_a_voltage_ceiling_trips_either_way_and_only_beyond(client: Client) -> None:
    if not client.has(Feature.VOLTAGE_LIMIT):
        pytest.skip(LACKS)
    supply = client.settings["supply_max_mv"] / 1.5
    above = round(0.9 * supply)
    assert not client.run(client.drive(200), voltage_limit_mv=above).all("fault")
    below = round(0.2 * supply)
    for duty in (0.4, -0.4):
        client.rest()
        record = client.run(client.drive(2000, duty), voltage_limit_mv=below)
        fault = record.one("fault")
        assert fault["fault"] is Fault.OVER_VOLTAGE
        volts = client.value(Channel.TERMINAL_VOLTAGE, fault["value"])
        assert 1e3 * abs(volts) > below
        assert (volts > 0) == (duty > 0)
        client.get("clear_fault")


@pytest.mark.parametrize("duty", [0.4, -0.4])
@pytest.mark.parametrize("reversed_", [0, 1])
def test_signs_that_agree_pass_and_a_reversed_encoder_trips(
    client: Client, duty: float, reversed_: int
) -> None:
    """The bench counts up where it is driven forward."""
    if not client.has(Feature.SIGN_CHECK):
        pytest.skip(LACKS)
    steps = client.coast(8), client.drive(1500, duty), client.coast(8)
    record = client.run(*steps, encoder_reversed=reversed_, **signs(client))
    if not reversed_:
        assert not record.all("fault")
        return
    fault = record.one("fault")
    assert (fault["fault"], fault["value"]) == (Fault.WRONG_SIGN, Channel.POSITION)


def test_signs_are_not_checked_beyond_their_time(client: Client) -> None:
    """A position that would trip at four counts comes after a millisecond's check."""
    if not client.has(Feature.SIGN_CHECK):
        pytest.skip(LACKS)
    step = client.drive(800)
    record = client.run(step, encoder_reversed=1, **signs(client, sign_check_ms=1))
    assert not record.all("fault")


@pytest.mark.parametrize(
    ("fault", "channel"),
    [
        ("current_reversed", Channel.CURRENT),
        ("encoder_reversed", Channel.POSITION),
    ],
)
@pytest.mark.parametrize("board_name", ["sim"])
def test_a_sensor_the_wrong_way_round_is_named(
    make_client: Callable[..., Client], fault: str, channel: Channel
) -> None:
    client = make_client(fault=fault)
    record = client.run(client.drive(1500), **signs(client, sign_check_ma=100))
    assert (record.one("fault")["fault"], record.one("fault")["value"]) == (
        Fault.WRONG_SIGN,
        channel,
    )


def test_inputs_are_described_and_told(client: Client) -> None:
    wired = client.identity["inputs"]
    assert client.has(Feature.INPUTS) == bool(wired)
    closed = client.get("read_status")["inputs"]
    assert closed & ~wired == 0
    for one in Input:
        reply = client.ask("describe_input", input=one)
        if wired >> one & 1:
            assert reply.fields["pin"]
            assert reply.fields["closed"] == closed >> one & 1
        else:
            assert reply.status is Status.NOT_SUPPORTED
    assert client.ask("describe_input", input=200).status is Status.NOT_SUPPORTED


@pytest.mark.needs("inputs")
def test_an_open_input_refuses_a_start_and_ends_a_run(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    guard, both = 1 << Input.GUARD_CLOSED, 1 << Input.GUARD_CLOSED | 1 << Input.PART_PRESENT
    board.close_inputs(both)
    assert client.get("read_status")["inputs"] == both
    record = client.start(client.drive(8000), inputs_required=both)
    client.wait(client.seconds(20))
    board.close_inputs(guard)
    client.follow(record)
    fault = record.one("fault")
    assert (fault["fault"], fault["value"]) == (Fault.INPUT_OPENED, 1 << Input.PART_PRESENT)
    assert board.is_open()
    client.get("clear_fault")
    hashes = client.load([client.drive(40)], inputs_required=both)
    assert client.ask("start", **hashes).status is Status.INPUT_OPEN
    assert not client.run(client.drive(40), inputs_required=guard).all("fault")
    board.close_inputs(0)
    assert not client.run(client.drive(40), inputs_required=0).all("fault")


def test_a_host_of_minor_2_goes_on_working(client: Client) -> None:
    """It sends the fields that it knows, and hashes those."""
    client.get("identify", host_major=1, host_minor=2)
    whole = encode_command("configure", 70, **client.settings)
    (reply,) = client.exchange(encode(whole[: COMMAND_HEADER + OLD]))
    hashed = zlib.crc32(whole[COMMAND_HEADER : COMMAND_HEADER + OLD])
    assert int.from_bytes(reply[REPLY_HEADER:], "little") == hashed
    config = client.get("read_config")
    assert config == client.settings | {"config_hash": hashed}
    added = client.get("add_step", index=0, **client.coast(20))
    hashes = {"config_hash": hashed, "program_hash": added["program_hash"]}
    assert client.ask("start", **hashes).status is Status.OK
    client.wait(client.seconds(40))


def test_brown_out_is_told_with_what_the_clock_needs(client: Client) -> None:
    identity = client.identity
    if identity["brown_out_mv"]:
        assert identity["brown_out_least_mv"], "a level without what is needed says nothing"
    assert identity["reset_cause"] in list(ResetCause)
