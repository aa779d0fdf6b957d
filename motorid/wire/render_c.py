"""The protocol as a C11 header: constants, enumerations, plain structs, byte-wise put and get.

The structs are ordinary ones, never laid over the wire's bytes, so alignment, padding and byte
order are the compiler's own business on every target.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from textwrap import wrap

from motorid.wire import spec as wire
from motorid.wire.hashes import layout_hash_of
from motorid.wire.spec import Field, Message, Spec

C_TYPES = {
    "u8": "uint8_t",
    "u16": "uint16_t",
    "u32": "uint32_t",
    "i16": "int16_t",
    "i32": "int32_t",
    "f32": "float",
}
TEXT = "text16"

HEAD = """\
/* The motorid wire protocol. Generated from motorid/wire/spec.toml: do not edit.
 *
 * Numbers stand on the wire little-endian without padding; put and get move them byte by byte.
 * wire_put_X writes the fields of a message and returns their length; wire_get_X reads them and
 * returns false when there are too few bytes (answer bad_length). Bytes after the known fields are
 * ignored, and fields that an older peer does not send read as 0. Headers (code, request, status)
 * have functions of their own: see docs/protocol.md.
 */
#ifndef WIRE_GEN_H
#define WIRE_GEN_H

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
"""

PRIMITIVES = """\
/* ---- numbers as bytes */

static inline void wire_put_u8(uint8_t *p, uint8_t v) { p[0] = v; }

static inline void wire_put_u16(uint8_t *p, uint16_t v) {
    p[0] = (uint8_t)(v & 0xFFu);
    p[1] = (uint8_t)(v >> 8);
}

static inline void wire_put_u32(uint8_t *p, uint32_t v) {
    wire_put_u16(p, (uint16_t)(v & 0xFFFFu));
    wire_put_u16(p + 2, (uint16_t)(v >> 16));
}

static inline void wire_put_i16(uint8_t *p, int16_t v) { wire_put_u16(p, (uint16_t)v); }

static inline void wire_put_i32(uint8_t *p, int32_t v) { wire_put_u32(p, (uint32_t)v); }

static inline void wire_put_f32(uint8_t *p, float v) {
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    wire_put_u32(p, bits);
}

static inline uint8_t wire_get_u8(const uint8_t *p) { return p[0]; }

static inline uint16_t wire_get_u16(const uint8_t *p) {
    return (uint16_t)(p[0] | (uint16_t)((uint16_t)p[1] << 8));
}

static inline uint32_t wire_get_u32(const uint8_t *p) {
    return wire_get_u16(p) | ((uint32_t)wire_get_u16(p + 2) << 16);
}

/* two's complement without an out-of-range conversion */
static inline int16_t wire_get_i16(const uint8_t *p) {
    const uint16_t bits = wire_get_u16(p);
    int16_t v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline int32_t wire_get_i32(const uint8_t *p) {
    const uint32_t bits = wire_get_u32(p);
    int32_t v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static inline float wire_get_f32(const uint8_t *p) {
    const uint32_t bits = wire_get_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

_Static_assert(CHAR_BIT == 8, "the wire's bytes have eight bits");
_Static_assert(sizeof(float) == 4, "f32 is the target's float");
_Static_assert(WIRE_MAX_COMMAND <= WIRE_MAX_PAYLOAD, "a command is a payload");

/* ---- headers; each returns its length, where the fields begin */

static inline size_t wire_put_command_header(uint8_t *p, uint8_t code, uint16_t request) {
    wire_put_u8(p, code);
    wire_put_u16(p + 1, request);
    return WIRE_COMMAND_HEADER;
}

static inline size_t wire_put_reply_header(uint8_t *p, uint8_t code, uint16_t request,
                                           uint8_t status) {
    wire_put_u8(p, (uint8_t)(code | WIRE_REPLY_BIT));
    wire_put_u16(p + 1, request);
    wire_put_u8(p + 3, status);
    return WIRE_REPLY_HEADER;
}

static inline size_t wire_put_event_header(uint8_t *p, uint8_t code) {
    wire_put_u8(p, code);
    return WIRE_EVENT_HEADER;
}
"""


def render(spec: Spec) -> str:
    """The whole of ``wire_gen.h``."""
    parts = [HEAD, _constants(spec), *_enums(spec), PRIMITIVES, "/* ---- commands and replies */\n"]
    for command in spec.commands.values():
        parts.append(_command(spec, command))
    parts.append("/* ---- events */\n")
    parts += [_event(spec, event) for event in spec.events.values()]
    return "\n".join(parts) + "\n#endif\n"


def _constants(spec: Spec) -> str:
    values: dict[str, str] = {
        "MAJOR": f"{spec.major}u",
        "MINOR": f"{spec.minor}u",
        "LAYOUT_HASH": f"0x{layout_hash_of(spec):08X}ul",
        "BAUD": f"{spec.baud}ul",
        "DELIMITER": f"{spec.delimiter}u",
        "MAX_PAYLOAD": f"{spec.max_payload}u",
        "MAX_FRAME": f"{spec.max_frame}u",
        "MAX_COMMAND": f"{spec.limits.max_command}u",
        "REQUEST_NONE": f"{spec.request_none}u",
        "CRC_POLYNOMIAL": f"0x{spec.crc.polynomial:04X}u",
        "CRC_INITIAL": f"0x{spec.crc.initial:04X}u",
        "CRC_CHECK": f"0x{spec.crc.check:04X}u",
        "BLOCK_SAMPLES": f"{spec.limits.block_samples}u",
        "BLOCK_AGE_MS": f"{spec.limits.block_age_ms}u",
        "REPLY_BIT": f"0x{wire.REPLY_BIT:02X}u",
        "COMMAND_HEADER": f"{wire.COMMAND_HEADER}u",
        "REPLY_HEADER": f"{wire.REPLY_HEADER}u",
        "EVENT_HEADER": f"{wire.EVENT_HEADER}u",
    }
    return "".join(f"#define WIRE_{name} {value}\n" for name, value in values.items())


def _enums(spec: Spec) -> Iterator[str]:
    for name, values in spec.enums.items():
        members = ",\n".join(
            f"    WIRE_{name.upper()}_{key.upper()} = {value}" for key, value in values.items()
        )
        yield f"enum wire_{name} {{\n{members}\n}};\n"


def _command(spec: Spec, command: Message) -> str:
    macro = f"WIRE_{command.name.upper()}"
    states = spec.enums["state"]
    mask = sum(1 << states[state] for state in command.states or states)
    *older, whole = wire.field_ends(command.fields)
    known = [f"(n) >= {whole}u"] if whole else ["true"]
    ends = " || \\\n     ".join([*known, *(f"(n) == {size}u" for size in older)])
    return _comment(command.doc) + "\n".join(
        [
            f"#define {macro}_CODE 0x{command.code:02X}u",
            f"#define {macro}_STATES 0x{mask:02X}u /* bit n: accepted in state n */",
            f"#define {macro}_ENDS(n) ({ends}) /* a field ends there, or later ones follow */",
            _group(command.name, command.fields),
            *_places(command),
            _group(f"{command.name}_reply", command.reply),
        ]
    )


STORED = ("write_front_end",)  # whose fields a board keeps as they stand on the wire


def _places(command: Message) -> Iterator[str]:
    """Where each field of a stored command stands, counted from the first."""
    if command.name in STORED:
        macro = f"WIRE_{command.name.upper()}_AT"
        yield "".join(
            f"#define {macro}_{field.name.upper()} {at}u\n"
            for at, field in _offsets(command.fields)
        )


def _event(spec: Spec, event: Message) -> str:
    name = f"event_{event.name}"
    text = _comment(event.doc) + "\n".join(
        [
            f"#define WIRE_{name.upper()}_CODE 0x{event.code:02X}u",
            _group(name, event.fields),
        ]
    )
    if not event.tail:
        return text
    size = Field("", event.tail, "", "").size
    macro = f"WIRE_{name.upper()}"
    return text + (
        f"/* samples of n channels that a payload has room for */\n"
        f"#define {macro}_ROOM(n) \\\n"
        f"    ((WIRE_MAX_PAYLOAD - WIRE_EVENT_HEADER - {macro}_SIZE) / ({size}u * (n)))\n"
    )


def _group(name: str, fields: tuple[Field, ...]) -> str:
    """A run of fields: its size, struct, put and get. Without fields, the size alone."""
    size = f"WIRE_{name.upper()}_SIZE"
    text = f"#define {size} {wire.fields_size(fields)}u /* fields, without the header */\n"
    if not fields:
        return text
    return (
        text
        + f"\ntypedef struct {{\n{''.join(_member(field) for field in fields)}}} wire_{name}_t;\n\n"
        + f"static inline size_t wire_put_{name}(uint8_t *p,\n"
        + f"        const wire_{name}_t *m) {{\n"
        + "".join(_put(at, field) for at, field in _offsets(fields))
        + f"    return {size};\n}}\n\n"
        + f"static inline bool wire_get_{name}(const uint8_t *p, size_t length,\n"
        + f"        wire_{name}_t *m) {{\n"
        + f"    if (length < {wire.required_size(fields)}u) {{\n        return false;\n    }}\n"
        + "".join(_get(at, field) for at, field in _offsets(fields))
        + "    return true;\n}\n"
    )


def _offsets(fields: Iterable[Field]) -> Iterator[tuple[int, Field]]:
    at = 0
    for field in fields:
        yield at, field
        at += field.size


def _member(field: Field) -> str:
    note = f"{field.doc} [{field.unit}]" if field.unit else field.doc
    name = f"char {field.name}[16]" if field.type == TEXT else f"{C_TYPES[field.type]} {field.name}"
    return "".join(f"    /* {line} */\n" for line in wrap(note, 92)) + f"    {name};\n"


def _put(at: int, field: Field) -> str:
    if field.type == TEXT:
        return f"    memcpy(p + {at}, m->{field.name}, sizeof m->{field.name});\n"
    return f"    wire_put_{field.type}(p + {at}, m->{field.name});\n"


def _get(at: int, field: Field) -> str:
    end = at + field.size
    if field.type == TEXT:
        read = f"memcpy(m->{field.name}, p + {at}, sizeof m->{field.name});"
        absent = f"memset(m->{field.name}, 0, sizeof m->{field.name});"
    else:
        read = f"m->{field.name} = wire_get_{field.type}(p + {at});"
        absent = f"m->{field.name} = 0;"
    if not field.since:
        return f"    {read}\n"
    return (
        f"    if (length >= {end}u) {{\n        {read}\n    }} else {{\n        {absent}\n    }}\n"
    )


def _comment(text: str) -> str:
    lines = wrap(text, 94)
    return "/* " + "\n * ".join(lines) + " */\n"
