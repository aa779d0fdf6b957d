"""Frames, resets and versions: what a board does with bytes, good and bad."""

from __future__ import annotations

import random
from collections.abc import Iterable
from typing import Any

import pytest

from motorid.acquire.channels import UNSYNCHRONISED
from motorid.wire.codec import encode_command
from motorid.wire.enums import Channel, ResetCause, State, Status
from motorid.wire.framing import DELIMITER, cobs_encode, crc16, encode
from motorid.wire.hashes import layout_hash
from motorid.wire.spec import REPLY_BIT, Field, load, required_size
from tests.conformance.client import LIMITS, Client

SPEC = load()


def nothing(fields: Iterable[Field]) -> dict[str, int | str]:
    """Zeros, and texts without a letter."""
    return {field.name: "" if field.type == "text16" else 0 for field in fields}


COMMANDS = sorted(SPEC.commands)
WITH_FIELDS = [name for name in COMMANDS if required_size(SPEC.commands[name].fields)]
UNKNOWN = (0x00, 0x10, 0x3F)  # codes of no command, without the bits of replies and events


def raw_frame(payload: bytes) -> bytes:
    """A frame of any payload, however short or long."""
    return cobs_encode(payload + crc16(payload).to_bytes(2, "little")) + b"\0"


def alive(client: Client) -> bool:
    return client.ask("heartbeat", sequence=0).status is Status.OK


def bad_frames() -> dict[str, bytes]:
    good = encode(encode_command("read_status", 7))
    broken = bytearray(good)
    broken[2] ^= 0x10
    return {
        "a flipped bit": bytes(broken),
        "a lost byte": good[:3] + good[4:],
        "only its end": good[4:],
        "a code past the end": b"\x09\x01\x02\0",
        "a check and nothing else": raw_frame(b""),
        "a single byte": b"\x01\0",
        "text": b"hello, is anybody there?\r\n\0",
    }


@pytest.mark.parametrize("kind", sorted(bad_frames()))
def test_a_bad_frame_is_dropped_and_the_next_one_taken(client: Client, kind: str) -> None:
    assert client.exchange(bad_frames()[kind]) == []
    assert alive(client)


@pytest.mark.parametrize(
    "data",
    [raw_frame(bytes([0x0B, 7, 0]) + bytes(200)), bytes([1]) * 400 + b"\0"],
    ids=["a command that is too long", "longer than any frame"],
)
def test_more_than_a_host_may_send_is_survived(client: Client, data: bytes) -> None:
    """A board need not have room for it, and may lose its delimiter too."""
    client.exchange(data)
    client.port.write(DELIMITER)
    assert alive(client)


def test_a_frame_cut_short_spoils_only_itself_when_a_delimiter_follows(client: Client) -> None:
    good = encode(encode_command("read_status", 7))
    assert client.exchange(good[:-3] + b"\0") == []
    assert alive(client)


def test_empty_frames_are_ignored(client: Client) -> None:
    assert client.exchange(b"\0" * 50) == []
    assert alive(client)


@pytest.mark.parametrize(
    "payload", [b"\x0b", b"\x0b\x07", b"\x8b\x07\x00\x00", b"\x43" + bytes(17)]
)
def test_what_is_no_command_is_not_answered(client: Client, payload: bytes) -> None:
    assert client.exchange(raw_frame(payload)) == []
    assert alive(client)


@pytest.mark.parametrize("code", UNKNOWN)
def test_unknown_commands_are_refused(client: Client, code: int) -> None:
    replies = client.exchange(raw_frame(bytes([code, 0x34, 0x12, 1, 2, 3])))
    assert replies == [bytes([code | REPLY_BIT, 0x34, 0x12, Status.UNKNOWN_COMMAND])]


@pytest.mark.parametrize("name", WITH_FIELDS)
def test_a_command_cut_short_is_refused(client: Client, name: str) -> None:
    size = required_size(SPEC.commands[name].fields)
    payload = bytes([SPEC.commands[name].code, 9, 0]) + bytes(size - 1)
    expected = bytes([SPEC.commands[name].code | REPLY_BIT, 9, 0, Status.BAD_LENGTH])
    assert client.exchange(raw_frame(payload)) == [expected]


def test_bytes_after_the_fields_are_ignored(client: Client) -> None:
    payload = encode_command("read_status", 11)
    longest = payload + bytes(range(1, LIMITS.max_command - len(payload) + 1))
    assert len(longest) == LIMITS.max_command
    (reply,) = client.exchange(raw_frame(longest))
    assert reply[:4] == bytes([payload[0] | REPLY_BIT, 11, 0, Status.OK])


def test_every_zero_of_a_payload_is_carried(client: Client) -> None:
    for sequence in (0, 0x0100, 0x0001, 0xFFFF):
        assert client.ask("heartbeat", 0x0100 | sequence & 1, sequence=sequence).status == Status.OK


def test_noise_between_commands_is_survived(client: Client) -> None:
    rng = random.Random(3)
    for _ in range(60):
        noise = rng.randbytes(rng.randrange(1, 120))
        client.port.write(noise + b"\0")
    client.wait(0.2)
    client.port.write(DELIMITER)
    assert alive(client)
    assert client.state in (State.IDLE, State.CONFIGURED, State.LOADED)


def test_several_commands_at_once_are_all_answered(client: Client) -> None:
    requests = [client.next_request() for _ in range(3)]
    frames = [encode(encode_command("read_status", request)) for request in requests]
    client.port.write(b"".join(frames))
    for request in requests:
        assert client.await_reply(request).status is Status.OK


# ---------------------------------------------------------------- identity


def test_identity_speaks_this_version(client: Client) -> None:
    identity = client.identity
    assert (identity["protocol_major"], identity["protocol_minor"]) == (SPEC.major, SPEC.minor)
    assert identity["layout_hash"] == layout_hash()
    assert identity["board"]
    assert identity["min_sample_period_ticks"] % identity["sample_period_step_ticks"] == 0
    assert identity["channel_count"] == len(client.descriptors)
    assert identity["decay_modes"] & 0b1110
    assert not identity["decay_modes"] & ~0b1110


def test_every_channel_is_described(client: Client) -> None:
    count = client.identity["channel_count"]
    assert sorted(client.descriptors) == list(client.descriptors)
    for fact in client.descriptors.values():
        assert fact["scale"] != 0
        assert fact["raw_min"] < fact["offset"] + 1 <= fact["raw_max"]
        assert (fact["aperture_ns"] == 0) == (fact["kind"] == 0)
    position = client.descriptors[Channel.POSITION]
    assert position["pwm_phase_permille"] == UNSYNCHRONISED
    assert client.ask("describe_channel", index=count).status is Status.BAD_VALUE
    assert client.ask("describe_channel", index=255).status is Status.BAD_VALUE


@pytest.mark.needs("fresh")
def test_hello_comes_once_after_power_on(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    client.wait(0.5)
    (hello,) = client.told
    assert hello.name == "hello"
    assert hello.fields["boot_id"] == client.identity["boot_id"]
    assert hello.fields["reset_cause"] == client.identity["reset_cause"]


@pytest.mark.needs("reset")
@pytest.mark.parametrize("running", [False, True])
def test_a_reset_forgets_everything_and_says_hello(board: Any, running: bool) -> None:
    client = Client(board.port)
    client.bring_up()
    first = client.identity["boot_id"]
    client.load([client.drive(5000)])
    if running:
        client.start(client.drive(5000))
        client.wait(client.seconds(100))
    client.told.clear()
    board.reset(int(ResetCause.EXTERNAL))
    client.wait(0.1)
    if board.name in ("sim", "host"):
        assert board.is_open()
    hellos = [message for message in client.told if message.name == "hello"]
    assert len(hellos) == 1
    identity = client.get("identify", host_major=SPEC.major, host_minor=SPEC.minor)
    assert identity["boot_id"] == hellos[0].fields["boot_id"] != first
    assert identity["state"] == State.IDLE
    assert client.ask("read_config").status is Status.NOT_CONFIGURED


@pytest.mark.needs("reset", "break")
def test_a_reset_by_the_watchdog_is_a_fault(board: Any) -> None:
    client = Client(board.port)
    client.bring_up()
    board.reset(int(ResetCause.WATCHDOG))
    client.wait(0.05)
    status = client.get("read_status")
    assert (status["state"], status["fault"]) == (State.FAULTED, 9)
    assert client.ask("configure", **client.settings).status is Status.FAULT_LATCHED
    assert client.get("clear_fault")["state"] == State.IDLE


# ---------------------------------------------------------------- versions


def test_a_host_of_another_major_is_refused_but_for_identify_and_stop(client: Client) -> None:
    foreign = {"host_major": SPEC.major + 1, "host_minor": 0}
    assert client.get("identify", **foreign)["protocol_major"] == SPEC.major
    for name in COMMANDS:
        if name in ("identify", "stop"):
            continue
        fields = nothing(SPEC.commands[name].fields)
        assert client.ask(name, **fields).status is Status.MAJOR_MISMATCH
    assert client.ask("stop").status is Status.OK
    unknown = client.exchange(raw_frame(bytes([0x3F, 1, 0])))
    assert unknown == [bytes([0xBF, 1, 0, Status.MAJOR_MISMATCH])]
    client.get("identify", host_major=SPEC.major, host_minor=0)
    assert alive(client)


def test_another_minor_is_welcome(client: Client) -> None:
    client.get("identify", host_major=SPEC.major, host_minor=SPEC.minor + 1)
    assert alive(client)
