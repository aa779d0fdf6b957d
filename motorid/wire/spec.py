"""The wire protocol as data: ``spec.toml``, checked and frozen."""

from __future__ import annotations

import struct
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from motorid.errors import MotoridError

PATH = Path(__file__).with_name("spec.toml")

REPLY_BIT = 0x80  # a reply's code is its command's with this bit set
EVENT_BIT = 0x40  # events have it, commands do not
COMMAND_HEADER = 3  # bytes: code, u16 request
REPLY_HEADER = 4  # bytes: code, u16 request, u8 status
EVENT_HEADER = 1  # bytes: code
FRAME_OVERHEAD = 4  # bytes: CRC, one COBS code, delimiter
MAX_PAYLOAD = 251  # with its CRC it stays below the 254 bytes at which COBS adds a second code

FORMATS = {
    "u8": "B",
    "u16": "H",
    "u32": "I",
    "i16": "h",
    "i32": "i",
    "f32": "f",
    "text16": "16s",
}


class SpecError(MotoridError):
    """``spec.toml`` contradicts itself; nothing that speaks the protocol may start."""


@dataclass(frozen=True, slots=True)
class Field:
    """One value in a message. ``since`` is the minor that appended it."""

    name: str
    type: str
    unit: str
    doc: str
    since: int = 0

    @property
    def size(self) -> int:
        """Bytes on the wire."""
        return struct.calcsize("<" + FORMATS[self.type])

    @property
    def enum(self) -> str | None:
        """Name of the enumeration whose values it takes, if any."""
        return self.unit.removeprefix("enum ") if self.unit.startswith("enum ") else None


@dataclass(frozen=True, slots=True)
class Message:
    """A command (with its reply's fields) or an event.

    ``tail`` is the type of the values that follow the fields to the payload's end, if any.
    ``states`` are those that accept the command; empty means every state.
    """

    name: str
    code: int
    doc: str
    fields: tuple[Field, ...]
    reply: tuple[Field, ...] = ()
    tail: str | None = None
    states: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Crc:
    """The frame's check: a catalogue name and its parameters."""

    name: str
    polynomial: int
    initial: int
    check: int


@dataclass(frozen=True, slots=True)
class Limits:
    """What both sides may rely on: sizes of blocks, deadlines, repetitions."""

    max_command: int
    block_samples: int
    block_age_ms: int
    reply_deadline_ms: int
    boot_deadline_ms: int
    attempts: int
    heartbeat_period_ms: int


@dataclass(frozen=True, slots=True)
class Hash:
    """The hash of configurations, programs and the layout."""

    name: str
    doc: str


@dataclass(frozen=True, slots=True)
class Spec:
    """The whole protocol."""

    name: str
    major: int
    minor: int
    baud: int
    delimiter: int
    max_payload: int
    request_none: int
    crc: Crc
    limits: Limits
    hash: Hash
    enums: Mapping[str, Mapping[str, int]]
    meanings: Mapping[str, Mapping[str, str]]
    commands: Mapping[str, Message]
    events: Mapping[str, Message]

    @property
    def max_frame(self) -> int:
        """Bytes of the longest frame, its delimiter included."""
        return self.max_payload + FRAME_OVERHEAD


@lru_cache(maxsize=1)
def load() -> Spec:
    """The protocol of this package. Raises SpecError when its file contradicts itself."""
    return parse(PATH.read_text(encoding="utf-8"))


def parse(text: str) -> Spec:
    """The protocol that a TOML text declares. Raises SpecError, naming the place."""
    try:
        data = tomllib.loads(text)
        spec = Spec(
            **data["protocol"],
            crc=Crc(**data["crc"]),
            limits=Limits(**data["limits"]),
            hash=Hash(**data["hash"]),
            enums=data["enum"],
            meanings=data["meaning"],
            commands={name: _message(name, m) for name, m in data["command"].items()},
            events={name: _message(name, m) for name, m in data["event"].items()},
        )
    except (tomllib.TOMLDecodeError, KeyError, TypeError) as error:
        raise SpecError(f"the protocol specification does not read: {error}") from error
    check(spec)
    return spec


def _message(name: str, data: Mapping[str, Any]) -> Message:
    return Message(
        name=name,
        code=data["code"],
        doc=data["doc"],
        fields=tuple(Field(*field) for field in data["fields"]),
        reply=tuple(Field(*field) for field in data.get("reply", ())),
        tail=data.get("tail"),
        states=tuple(data.get("states", ())),
    )


def fields_size(fields: Iterable[Field]) -> int:
    """Bytes that the fields take on the wire."""
    return sum(field.size for field in fields)


def required_size(fields: Iterable[Field]) -> int:
    """Bytes that every peer of this major sends: the fields that were there from minor 0."""
    return sum(field.size for field in fields if not field.since)


def field_ends(fields: tuple[Field, ...]) -> tuple[int, ...]:
    """Bytes that a peer may send, ascending: the fields of minor 0, and any that came after."""
    first = sum(not field.since for field in fields)
    return tuple(fields_size(fields[:count]) for count in range(first, len(fields) + 1))


def check(spec: Spec) -> None:
    """Raise SpecError at the first contradiction."""
    if spec.max_payload > MAX_PAYLOAD:
        raise SpecError(f"max_payload is above {MAX_PAYLOAD}: a frame must be one COBS group")
    for name, values in spec.enums.items():
        if values.keys() != spec.meanings.get(name, {}).keys():
            raise SpecError(f"[meaning.{name}] must explain each value of [enum.{name}]")
        if len(set(values.values())) != len(values) or not all(
            0 <= value <= 0xFF for value in values.values()
        ):
            raise SpecError(f"enum {name} repeats a value or leaves 0 to 255")
    _check_codes(spec)
    for command in spec.commands.values():
        most = spec.limits.max_command
        _check_fields(spec, command.name, command.fields, most - COMMAND_HEADER)
        room = spec.max_payload - REPLY_HEADER
        _check_fields(spec, f"{command.name} reply", command.reply, room)
        if unknown := set(command.states) - set(spec.enums["state"]):
            raise SpecError(f"command {command.name} names unknown states {sorted(unknown)}")
    for event in spec.events.values():
        _check_fields(spec, event.name, event.fields, spec.max_payload - EVENT_HEADER)
        if event.tail and any(field.since for field in event.fields):
            raise SpecError(f"event {event.name} has a tail, so no field can be appended")


def _check_codes(spec: Spec) -> None:
    seen: dict[int, str] = {}
    for kind, messages, bit in (
        ("command", spec.commands, 0),
        ("event", spec.events, EVENT_BIT),
    ):
        for name, message in messages.items():
            if message.code in seen:
                raise SpecError(f"{kind} {name} has the code of {seen[message.code]}")
            if not 0 < message.code < REPLY_BIT or message.code & EVENT_BIT != bit:
                raise SpecError(f"{kind} {name} has a code outside its range: {message.code:#04x}")
            seen[message.code] = name


def _check_fields(spec: Spec, where: str, fields: tuple[Field, ...], room: int) -> None:
    names = [field.name for field in fields]
    if len(set(names)) != len(names):
        raise SpecError(f"{where} names a field twice")
    for field in fields:
        if field.type not in FORMATS:
            raise SpecError(f"{where}.{field.name} has the unknown type {field.type}")
        if field.enum is not None and field.enum not in spec.enums:
            raise SpecError(f"{where}.{field.name} names the unknown enum {field.enum}")
        if field.since > spec.minor:
            raise SpecError(f"{where}.{field.name} is newer than minor {spec.minor}")
    if [field.since for field in fields] != sorted(field.since for field in fields):
        raise SpecError(f"{where} has an appended field before an older one")
    if fields_size(fields) > room:
        raise SpecError(f"{where} has {fields_size(fields)} bytes of fields, room is for {room}")
