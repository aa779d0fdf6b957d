"""The protocol as a page for people: prose from ``protocol.md.in``, tables from the spec."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from motorid.errors import MotoridError
from motorid.wire import framing
from motorid.wire import spec as wire
from motorid.wire.hashes import config_hash, layout_hash_of, program_hash
from motorid.wire.layout import Layout
from motorid.wire.spec import Field, Message, Spec

TEMPLATE = Path(__file__).with_name("protocol.md.in")

TYPES = (
    ("u8, u16, u32", "1, 2, 4", "unsigned integer"),
    ("i16, i32", "2, 4", "signed integer, two's complement"),
    ("f32", "4", "IEEE 754 binary32"),
    ("text16", "16", "ASCII, zero-padded"),
)

EXAMPLE_CONFIG = {
    "sample_period_ticks": 8000,
    "channels": 0b1011,
    "mode": 0,
    "encoder_reversed": 0,
    "current_limit_ma": 2500,
    "speed_limit_counts_s": 300_000,
    "supply_min_mv": 9000,
    "supply_max_mv": 14_000,
    "run_time_limit_ms": 60_000,
    "host_silence_ms": 500,
}
EXAMPLE_STEPS = (
    {"index": 0, "kind": 1, "decay": 1, "level": 500_000, "ticks": 16_000_000},
    {"index": 1, "kind": 0, "decay": 0, "level": 0, "ticks": 8_000_000},
)


def render(spec: Spec) -> str:
    """The whole of ``docs/protocol.md``. Raises MotoridError on a placeholder without a value."""
    values = _values(spec)

    def value(match: re.Match[str]) -> str:
        if match[1] not in values:
            raise MotoridError(f"{TEMPLATE.name} asks for the unknown value {match[1]}")
        return values[match[1]]

    return re.sub(r"\{\{(\w+)\}\}", value, TEMPLATE.read_text(encoding="utf-8"))


def _values(spec: Spec) -> dict[str, str]:
    return {
        "version": f"{spec.major}.{spec.minor}",
        "baud": f"{spec.baud:,}".replace(",", " "),
        "max_payload": str(spec.max_payload),
        "max_command": str(spec.limits.max_command),
        "max_frame": str(spec.max_frame),
        "frame_overhead": str(wire.FRAME_OVERHEAD),
        "crc_name": spec.crc.name,
        "crc_polynomial": f"0x{spec.crc.polynomial:04X}",
        "crc_initial": f"0x{spec.crc.initial:04X}",
        "crc_check": f"0x{spec.crc.check:04X}",
        "reply_bit": f"0x{wire.REPLY_BIT:02X}",
        "request_none": str(spec.request_none),
        "hash_name": spec.hash.name,
        "layout_hash": f"0x{layout_hash_of(spec):08X}",
        "config_size": str(wire.fields_size(spec.commands["configure"].fields)),
        "step_size": str(wire.fields_size(spec.commands["add_step"].fields)),
        **{name: str(getattr(spec.limits, name)) for name in spec.limits.__slots__},
        **_blocks(spec),
    }


def _blocks(spec: Spec) -> dict[str, str]:
    return {
        "types": _table(("type", "bytes", "is"), TYPES),
        "frame_example": _frame_example(spec),
        "hash_example": _hash_example(spec),
        "link_budget": _link_budget(spec),
        "accepts": _accepts(spec),
        "status": _enum(spec, "status"),
        "states": _enum(spec, "state"),
        "fault": _enum(spec, "fault"),
        "commands": "\n\n".join(_command(command) for command in spec.commands.values()),
        "events": "\n\n".join(_event(event) for event in spec.events.values()),
        "enums": "\n\n".join(f"### {name}\n\n{_enum(spec, name)}" for name in spec.enums),
    }


def _table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for row in rows:
        cells = (str(cell).replace("|", "\\|") for cell in row)
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _enum(spec: Spec, name: str) -> str:
    meanings = spec.meanings[name]
    rows = ((value, f"`{key}`", meanings[key]) for key, value in spec.enums[name].items())
    return _table(("value", "name", "means"), rows)


def _fields(fields: Sequence[Field], header: int) -> str:
    rows, at = [], header
    for field in fields:
        unit = f"enum [{field.enum}](#{field.enum})" if field.enum else field.unit
        doc = f"{field.doc} (since minor {field.since})" if field.since else field.doc
        rows.append((at, f"`{field.name}`", field.type, unit, doc))
        at += field.size
    return _table(("offset", "field", "type", "unit", "meaning"), rows)


def _group(title: str, fields: Sequence[Field], header: int) -> str:
    size = header + wire.fields_size(fields)
    if not fields:
        return f"{title}, {size} bytes: no fields."
    return f"{title}, {size} bytes:\n\n{_fields(fields, header)}"


def _command(command: Message) -> str:
    states = ", ".join(command.states) if command.states else "every state"
    return "\n\n".join(
        [
            f"### {command.name} (0x{command.code:02X})",
            f"{command.doc}\nAccepted in: {states}.",
            _group("Command", command.fields, wire.COMMAND_HEADER),
            _group(
                f"Reply (0x{command.code | wire.REPLY_BIT:02X})", command.reply, wire.REPLY_HEADER
            ),
        ]
    )


def _event(event: Message) -> str:
    text = _group("Event", event.fields, wire.EVENT_HEADER)
    if event.tail:
        text += f"\n\nThen the samples, {event.tail} each."
    return f"### {event.name} (0x{event.code:02X})\n\n{event.doc}\n\n{text}"


def _accepts(spec: Spec) -> str:
    rows = [
        (
            f"`{name}`",
            *("yes" if s in (command.states or (s,)) else "" for s in spec.enums["state"]),
        )
        for name, command in spec.commands.items()
    ]
    return _table(("command", *spec.enums["state"]), rows)


def samples_in_block(spec: Spec, channels: int) -> int:
    """Samples of that many channels in a full block."""
    header = wire.EVENT_HEADER + wire.fields_size(spec.events["sample_block"].fields)
    return min(spec.limits.block_samples, (spec.max_payload - header) // (2 * channels))


def bytes_a_sample(spec: Spec, channels: int) -> float:
    """Bytes on the wire for one sample of that many channels, in full blocks."""
    header = wire.EVENT_HEADER + wire.fields_size(spec.events["sample_block"].fields)
    return 2 * channels + (header + wire.FRAME_OVERHEAD) / samples_in_block(spec, channels)


def _link_budget(spec: Spec) -> str:
    rows = (
        (
            channels,
            samples_in_block(spec, channels),
            f"{bytes_a_sample(spec, channels):.2f}",
            f"{spec.baud / 10 / bytes_a_sample(spec, channels) / 1000:.1f} kHz",
        )
        for channels in range(1, len(spec.enums["channel"]) + 1)
    )
    head = ("channels", "samples in a full block", "bytes a sample", "rate that fills the line")
    return _table(head, rows)


def _frame_example(spec: Spec) -> str:
    identify = spec.commands["identify"]
    fields = Layout("identify", identify.fields).pack(
        {"host_major": spec.major, "host_minor": spec.minor}
    )
    payload = bytes([identify.code]) + (1).to_bytes(2, "little") + fields
    return "\n".join(
        [
            "For example `identify` as request 1:\n",
            f"    payload  {payload.hex(' ')}",
            f"    CRC      0x{framing.crc16(payload):04X}",
            f"    frame    {framing.encode(payload).hex(' ')}",
        ]
    )


def _hash_example(spec: Spec) -> str:
    configure = Layout("configure", spec.commands["configure"].fields)
    add_step = Layout("add_step", spec.commands["add_step"].fields)
    named = ", ".join(f"{name} {value}" for name, value in EXAMPLE_CONFIG.items())
    steps = [add_step.pack(step).hex() for step in EXAMPLE_STEPS]
    return "\n".join(
        [
            f"For example the configuration {named}:\n",
            f"    bytes  {configure.pack(EXAMPLE_CONFIG).hex()}",
            f"    hash   0x{config_hash(EXAMPLE_CONFIG):08X}",
            "\nand the program of half duty with slow decay for 16 000 000 ticks, then coast for"
            "\n8 000 000:\n",
            *(f"    bytes  {step}" for step in steps),
            f"    hash   0x{program_hash(EXAMPLE_STEPS):08X}",
        ]
    )
