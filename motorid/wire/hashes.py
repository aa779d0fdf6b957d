"""Hashes by which host and board agree that they mean the same: CRC-32/ISO-HDLC (zlib's)."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

from motorid.wire.layout import Layout
from motorid.wire.spec import Field, Message, Spec, fields_size, load


def config_hash(fields: Mapping[str, Any], minor: int | None = None) -> int:
    """Hash of a configuration: of the configure fields as they stand on the wire.

    ``minor`` is the board's where it is older: it knows its own fields alone. Other keys are
    ignored, so that the reply to read_config can be passed as it is.
    """
    known = load().minor if minor is None else minor
    size = fields_size(field for field in _layout("configure").fields if field.since <= known)
    return zlib.crc32(_packed("configure", fields)[:size])


def program_hash(steps: Iterable[Mapping[str, Any]]) -> int:
    """Hash of a program: of the add_step fields of all its steps, one after the other; empty: 0."""
    return zlib.crc32(b"".join(_packed("add_step", step) for step in steps))


def front_end_hash(facts: Mapping[str, Any]) -> int:
    """Hash of facts of a front end: of the write_front_end fields as they stand on the wire."""
    return zlib.crc32(front_end_bytes(facts))


def front_end_bytes(facts: Mapping[str, Any]) -> bytes:
    """Facts of a front end as they stand on the wire, and in a board's memory."""
    return _packed("write_front_end", facts)


@lru_cache(maxsize=1)
def layout_hash() -> int:
    """Hash of this package's layout text."""
    return layout_hash_of(load())


def layout_hash_of(spec: Spec) -> int:
    """Hash of a protocol's layout text."""
    return zlib.crc32(layout_text(spec).encode("ascii"))


@lru_cache(maxsize=4)
def _layout(command: str) -> Layout:
    return Layout(command, load().commands[command].fields)


def _packed(command: str, fields: Mapping[str, Any]) -> bytes:
    layout = _layout(command)
    return layout.pack({name: fields[name] for name in layout.names if name in fields})


def layout_text(spec: Spec) -> str:
    """Everything that decides what a byte means, one line a message and an enumeration."""
    lines = [f"{spec.name} {spec.major}.{spec.minor}"]
    for name, values in spec.enums.items():
        lines.append(f"enum {name} " + " ".join(f"{k}={v}" for k, v in values.items()))
    lines += [_line("command", message) for message in spec.commands.values()]
    lines += [_line("event", message) for message in spec.events.values()]
    return "\n".join(lines) + "\n"


def _line(kind: str, message: Message) -> str:
    parts = [kind, message.name, f"{message.code:02x}", _fields(message.fields)]
    if kind == "command":
        parts += ["->", _fields(message.reply)]
    if message.tail:
        parts += ["tail", message.tail]
    return " ".join(parts)


def _fields(fields: tuple[Field, ...]) -> str:
    return "(" + ",".join(f"{f.name}:{f.type}:{f.unit}" for f in fields) + ")"
