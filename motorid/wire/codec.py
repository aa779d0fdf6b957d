"""Payloads to messages and back, for both ends of the wire. Pure."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motorid.wire.enums import Channel, Status
from motorid.wire.layout import BadPayload, Layout, UnknownMessage
from motorid.wire.spec import (
    COMMAND_HEADER,
    EVENT_BIT,
    EVENT_HEADER,
    REPLY_BIT,
    REPLY_HEADER,
    Message,
    load,
)

RAW = np.dtype("<i2")  # a sample on the wire
SAMPLE_BLOCK = "sample_block"


@dataclass(frozen=True, slots=True)
class Command:
    """What the host asks."""

    name: str
    request: int
    fields: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Reply:
    """What the board answers; ``fields`` is empty unless ``status`` is OK."""

    name: str
    request: int
    status: Status
    fields: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Event:
    """What the board says unasked."""

    name: str
    fields: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class SampleBlock:
    """A stretch of consecutive samples: raw counts, shape (count, len(channels))."""

    sequence: int
    first_tick: int
    dropped: int
    position: int
    channels: tuple[Channel, ...]
    samples: NDArray[np.int16]
    name: ClassVar[str] = SAMPLE_BLOCK


@dataclass(frozen=True)
class _Tables:
    """Messages by code, and layouts by name."""

    commands: Mapping[int, Message]
    events: Mapping[int, Message]
    command_layouts: Mapping[str, Layout]
    reply_layouts: Mapping[str, Layout]
    event_layouts: Mapping[str, Layout]


@lru_cache(maxsize=1)
def _tables() -> _Tables:
    spec = load()
    commands, events = spec.commands.values(), spec.events.values()
    return _Tables(
        commands={message.code: message for message in commands},
        events={message.code: message for message in events},
        command_layouts={m.name: Layout(m.name, m.fields) for m in commands},
        reply_layouts={m.name: Layout(f"{m.name} reply", m.reply) for m in commands},
        event_layouts={m.name: Layout(m.name, m.fields) for m in events},
    )


# ---------------------------------------------------------------- encoding


def encode_command(name: str, request: int, /, **fields: Any) -> bytes:
    """Payload of a command. Raises ValueError when a field is absent, foreign or too big."""
    head = struct.pack("<BH", load().commands[name].code, request)
    return head + _tables().command_layouts[name].pack(fields)


def encode_reply(name: str, request: int, status: Status, /, **fields: Any) -> bytes:
    """Payload of the reply to a command; a status other than OK carries no fields."""
    head = encode_refusal(load().commands[name].code, request, status)
    return head if status else head + _tables().reply_layouts[name].pack(fields)


def encode_refusal(code: int, request: int, status: Status) -> bytes:
    """Payload of the reply to a command that could not be decoded."""
    return struct.pack("<BHB", code | REPLY_BIT, request, status)


def encode_event(name: str, /, **fields: Any) -> bytes:
    """Payload of an event.

    A sample_block takes ``samples``, int16 of shape (count, channels), in place of ``count``;
    its ``channels`` is the bit mask (see ``channel_mask``).
    """
    code, layout = bytes([load().events[name].code]), _tables().event_layouts[name]
    if name != SAMPLE_BLOCK:
        return code + layout.pack(fields)
    samples = _raw(fields.pop("samples"), int(fields["channels"]))
    return code + layout.pack(fields | {"count": len(samples)}) + samples.tobytes()


def _raw(samples: ArrayLike, mask: int) -> NDArray[np.int16]:
    """Samples in wire order. Raises ValueError when they are not int16, one column a channel."""
    array = np.asarray(samples)
    if array.ndim != 2 or array.shape[1] != mask.bit_count():
        raise ValueError(
            f"samples have shape {array.shape}, not (count, {mask.bit_count()} channels)"
        )
    if not np.can_cast(array.dtype, np.int16):
        raise ValueError(f"samples are {array.dtype}, not int16")
    return np.ascontiguousarray(array, dtype=RAW)


def channel_mask(channels: Iterable[Channel]) -> int:
    """Bit n set for channel n."""
    mask = 0
    for channel in channels:
        mask |= 1 << channel
    return mask


@lru_cache(maxsize=256)
def mask_channels(mask: int) -> tuple[Channel, ...]:
    """Channels of a mask in ascending order. Raises ValueError on a bit without a channel."""
    return tuple(Channel(bit) for bit in range(mask.bit_length()) if mask >> bit & 1)


# ---------------------------------------------------------------- decoding


def name_of(enum: type[IntEnum], number: int) -> str:
    """An enumeration's name, or its number where a newer board says what we do not know."""
    try:
        return enum(number).name.lower()
    except ValueError:
        return str(number)


def decode(payload: bytes) -> Command | Reply | Event | SampleBlock:
    """The message in a payload. Raises BadPayload."""
    if not payload:
        raise BadPayload("an empty payload")
    code = payload[0]
    if code & REPLY_BIT:
        return _decode_reply(payload)
    return _decode_event(payload) if code & EVENT_BIT else _decode_command(payload)


def _decode_command(payload: bytes) -> Command:
    tables, code = _tables(), payload[0]
    if len(payload) < COMMAND_HEADER:
        raise BadPayload("a command without a whole request number", code)
    request = int.from_bytes(payload[1:COMMAND_HEADER], "little")
    if code not in tables.commands:
        raise UnknownMessage(f"unknown command {code:#04x}", code, request, Status.UNKNOWN_COMMAND)
    name = tables.commands[code].name
    try:
        fields = tables.command_layouts[name].unpack(payload, COMMAND_HEADER)
    except BadPayload as error:
        raise BadPayload(str(error), code, request) from None
    return Command(name, request, fields)


def _decode_reply(payload: bytes) -> Reply:
    tables, code = _tables(), payload[0] & ~REPLY_BIT
    if code not in tables.commands:
        raise UnknownMessage(f"a reply to the unknown command {code:#04x}")
    name = tables.commands[code].name
    if len(payload) < REPLY_HEADER:
        raise BadPayload(f"{name} reply: {len(payload)} bytes are no reply")
    request = int.from_bytes(payload[1:COMMAND_HEADER], "little")
    try:
        status = Status(payload[COMMAND_HEADER])
    except ValueError:
        raise BadPayload(f"{name} reply: unknown status {payload[COMMAND_HEADER]}") from None
    fields = {} if status else tables.reply_layouts[name].unpack(payload, REPLY_HEADER)
    return Reply(name, request, status, fields)


def _decode_event(payload: bytes) -> Event | SampleBlock:
    tables, code = _tables(), payload[0]
    if code not in tables.events:
        raise UnknownMessage(f"unknown event {code:#04x}")
    name = tables.events[code].name
    layout = tables.event_layouts[name]
    fields = layout.unpack(payload, EVENT_HEADER)
    if name != SAMPLE_BLOCK:
        return Event(name, fields)
    return _sample_block(fields, payload, EVENT_HEADER + layout.struct.size)


def _sample_block(fields: dict[str, Any], payload: bytes, start: int) -> SampleBlock:
    count = fields.pop("count")
    try:
        channels = mask_channels(fields.pop("channels"))
    except ValueError as error:
        raise BadPayload(f"{SAMPLE_BLOCK}: {error}") from None
    total = count * len(channels)
    if not total or len(payload) < start + total * RAW.itemsize:
        raise BadPayload(
            f"{SAMPLE_BLOCK}: {len(payload) - start} bytes for {count} samples "
            f"of {len(channels)} channels"
        )
    samples = np.frombuffer(payload, RAW, total, start).reshape(count, len(channels))
    return SampleBlock(**fields, channels=channels, samples=samples)


__all__ = [
    "BadPayload",
    "Command",
    "Event",
    "Reply",
    "SampleBlock",
    "UnknownMessage",
    "channel_mask",
    "decode",
    "encode_command",
    "encode_event",
    "encode_refusal",
    "encode_reply",
    "mask_channels",
]
