"""Codec: every message there and back, frozen vectors, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from motorid import program
from motorid.wire import codec, enums, framing
from motorid.wire.enums import Channel, Mode, State, Status, StepKind
from motorid.wire.layout import Layout
from motorid.wire.spec import Field, load
from tests.wire.messages import ANY, Sent

SPEC = load()
VECTORS = json.loads(Path(__file__).with_name("vectors.json").read_text(encoding="utf-8"))


def assert_same(found: object, expected: object) -> None:
    if not isinstance(expected, codec.SampleBlock):
        assert found == expected
        return
    assert isinstance(found, codec.SampleBlock)
    np.testing.assert_array_equal(found.samples, expected.samples)
    assert replace(found, samples=None).__repr__() == replace(expected, samples=None).__repr__()


@pytest.mark.slow
@given(ANY)
def test_every_message_survives_the_wire(sent: Sent) -> None:
    [frame] = framing.Decoder().feed(framing.encode(sent.payload))
    assert isinstance(frame, framing.Frame)
    assert_same(codec.decode(frame.payload), sent.message)


@pytest.mark.slow
@given(ANY, st.binary(min_size=1, max_size=9))
def test_bytes_of_a_newer_minor_are_ignored(sent: Sent, appended: bytes) -> None:
    assert_same(codec.decode(sent.payload + appended), sent.message)


@pytest.mark.slow
@given(ANY, st.integers(1, 60))
def test_a_cut_message_is_refused(sent: Sent, cut: int) -> None:
    assume(len(sent.payload) - cut not in sent.ends)
    with pytest.raises(codec.BadPayload):
        codec.decode(sent.payload[: max(0, len(sent.payload) - cut)])


@pytest.mark.slow
@given(st.one_of(st.binary(max_size=300), ANY.map(lambda sent: sent.payload)))
def test_any_payload_decodes_or_is_refused(payload: bytes) -> None:
    try:
        message = codec.decode(payload)
    except codec.BadPayload:
        return
    assert message.name in {**SPEC.commands, **SPEC.events}


def encode_vector(vector: dict[str, Any]) -> bytes:
    kind, name, fields = vector["kind"], vector["name"], dict(vector["fields"])
    if kind == "command":
        return codec.encode_command(name, vector["request"], **fields)
    if kind == "reply":
        status = Status[vector["status"].upper()]
        return codec.encode_reply(name, vector["request"], status, **fields)
    if name == codec.SAMPLE_BLOCK:
        fields["samples"] = np.array(fields["samples"], np.int16)
    return codec.encode_event(name, **fields)


def appended_by_a_minor(vector: dict[str, Any]) -> list[str]:
    """Names of the fields that are not in minor 0."""
    message = {**SPEC.commands, **SPEC.events}[vector["name"]]
    fields = message.reply if vector["kind"] == "reply" else message.fields
    whole = vector["kind"] != "reply" or vector["status"] == "ok"
    return [field.name for field in fields if field.since and whole]


@pytest.mark.parametrize("vector", VECTORS, ids=lambda v: f"{v['kind']}-{v['name']}")
def test_bytes_of_major_1_never_change(vector: dict[str, Any]) -> None:
    payload = bytes.fromhex(vector["payload"])
    encoded = encode_vector(vector)
    assert encoded == payload + bytes(len(encoded) - len(payload))  # appended fields, absent there
    appended = dict.fromkeys(appended_by_a_minor(vector), 0)
    assert framing.encode(payload) == bytes.fromhex(vector["frame"])
    message = codec.decode(payload)
    assert message.name == vector["name"]
    if not isinstance(message, codec.SampleBlock):
        assert message.fields == appended | vector["fields"]


def test_vectors_cover_every_message() -> None:
    kinds = {(vector["kind"], vector["name"]) for vector in VECTORS}
    commands = {(kind, name) for kind in ("command", "reply") for name in SPEC.commands}
    assert kinds == commands | {("event", name) for name in SPEC.events}


def test_enumerations_come_as_members_and_unknown_values_as_numbers() -> None:
    reply = codec.decode(codec.encode_reply("stop", 1, Status.OK, state=3))
    assert isinstance(reply, codec.Reply)
    assert reply.fields["state"] is State.LOADED
    unknown = codec.decode(codec.encode_reply("stop", 1, Status.OK, state=77))
    assert isinstance(unknown, codec.Reply)
    assert unknown.fields == {"state": 77}


def test_sample_block_is_a_view_of_raw_counts() -> None:
    samples = np.arange(-6, 6, dtype=np.int16).reshape(4, 3)
    payload = codec.encode_event(
        "sample_block",
        sequence=65535,
        first_tick=2**32 - 1,
        dropped=2,
        position=2**31,
        channels=0b1011,
        samples=samples,
    )
    block = codec.decode(payload)
    assert isinstance(block, codec.SampleBlock)
    assert block.name == "sample_block"
    assert block.channels == (Channel.CURRENT, Channel.TERMINAL_VOLTAGE, Channel.POSITION)
    assert (block.sequence, block.first_tick) == (65535, 2**32 - 1)
    assert (block.dropped, block.position) == (2, 2**31)
    assert block.samples.dtype == np.int16
    np.testing.assert_array_equal(block.samples, samples)
    assert block != replace(block)  # two blocks are two arrivals, and arrays have no single answer


def test_channel_masks() -> None:
    assert codec.channel_mask([Channel.POSITION, Channel.CURRENT]) == 0b1001
    assert codec.mask_channels(0b1001) == (Channel.CURRENT, Channel.POSITION)
    with pytest.raises(ValueError, match="4"):
        codec.mask_channels(0b10001)


BLOCK = {"sequence": 0, "first_tick": 0, "dropped": 0, "position": 0, "channels": 1}


@pytest.mark.parametrize(
    "head",
    [
        {**BLOCK, "count": 0},
        {**BLOCK, "count": 2},
        {**BLOCK, "count": 1, "channels": 0},
        {**BLOCK, "count": 1, "channels": 0x10},
    ],
)
def test_contradictory_blocks_are_refused(head: dict[str, int]) -> None:
    layout = Layout("sample_block", SPEC.events["sample_block"].fields)
    code = bytes([SPEC.events["sample_block"].code])
    with pytest.raises(codec.BadPayload, match="sample_block"):
        codec.decode(code + layout.pack(head) + b"\1\2")


@pytest.mark.parametrize(
    ("samples", "complaint"),
    [
        (np.zeros((4, 2), np.int16), "shape"),
        (np.zeros(4, np.int16), "shape"),
        (np.zeros((4, 1), np.int32), "int32"),
        (np.zeros((4, 1)), "float64"),
    ],
)
def test_samples_that_would_be_cut_are_refused(samples: np.ndarray, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        codec.encode_event("sample_block", samples=samples, **BLOCK)


def test_a_board_can_answer_what_it_cannot_decode() -> None:
    with pytest.raises(codec.UnknownMessage) as unknown:
        codec.decode(b"\x3f\x07\x00")
    assert (unknown.value.code, unknown.value.request) == (0x3F, 7)
    assert unknown.value.status is Status.UNKNOWN_COMMAND
    with pytest.raises(codec.BadPayload) as short:
        codec.decode(codec.encode_command("heartbeat", 9, sequence=1)[:-1])
    assert (short.value.code, short.value.request) == (0x09, 9)
    assert short.value.status is Status.BAD_LENGTH
    answer = codec.decode(codec.encode_refusal(0x09, 9, short.value.status))
    assert answer == codec.Reply("heartbeat", 9, Status.BAD_LENGTH, {})


def test_a_reply_with_an_unknown_status_is_refused() -> None:
    with pytest.raises(codec.BadPayload, match="unknown status 200"):
        codec.decode(b"\x88\x01\x00\xc8")


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({}, "absent fields .'samples'"),
        ({"samples": 1, "extra": 2}, "foreign fields .'extra'"),
        ({"samples": 65536}, "samples = 65536 does not fit u16"),
        ({"samples": -1}, "samples = -1 does not fit u16"),
        ({"samples": 1.5}, "samples = 1.5 does not fit u16"),
    ],
)
def test_fields_that_do_not_fit_are_named(fields: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        codec.encode_command("zero", 1, **fields)


@pytest.mark.parametrize("board", ["seventeen letters", "Ω-board"])
def test_texts_that_do_not_fit_are_refused(board: str) -> None:
    layout = Layout("x", (Field("board", "text16", "", ""),))
    with pytest.raises(ValueError, match="16 ASCII"):
        layout.pack({"board": board})


def test_fields_appended_by_a_minor_are_optional_whole() -> None:
    old = (Field("mode", "u8", "enum mode", ""),)
    layout = Layout("x", (*old, Field("a", "u16", "", "", 1), Field("b", "u32", "", "", 2)))
    assert layout.unpack(b"\x01") == {"mode": Mode.BURST, "a": 0, "b": 0}
    assert layout.unpack(b"\x01\x02\x00") == {"mode": Mode.BURST, "a": 2, "b": 0}
    assert layout.unpack(b"\x01\x02\x00\x03\x00\x00\x00\x99")["b"] == 3
    for cut in (b"", b"\x01\x02", b"\x01\x02\x00\x03"):
        with pytest.raises(codec.BadPayload, match=f"{len(cut)} bytes of fields, 7 expected"):
            layout.unpack(cut)


def test_step_kinds_are_those_of_programs() -> None:
    assert dict(program.StepKind.__members__) == dict(StepKind.__members__)
    assert dict(program.Decay.__members__) == dict(enums.Decay.__members__)
