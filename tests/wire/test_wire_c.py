"""The generated header, compiled: the same vectors as Python's, there and back."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from motorid.wire import render_c
from motorid.wire.generate import ROOT
from motorid.wire.spec import (
    COMMAND_HEADER,
    EVENT_HEADER,
    PATH,
    REPLY_HEADER,
    Field,
    Message,
    load,
    parse,
    required_size,
)

SPEC = load()
CORE = ROOT / "firmware" / "core"
VECTORS = json.loads(Path(__file__).with_name("vectors.json").read_text(encoding="utf-8"))
FLAGS = ["-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Werror"]
UNDEFINED = ["-fsanitize=undefined", "-fno-sanitize-recover=all"]

HEAD = """\
#include <stdio.h>
#include "wire_gen.h"
#define CHECK(c) do { if (!(c)) { printf("line %d: %s\\n", __LINE__, #c); return 1; } } while (0)
"""


def compiler(name: str) -> str:
    found = shutil.which(name)
    if found is None:
        pytest.skip(f"no C compiler {name}: the generated header is not compiled with it")
    return found


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def literal(field: Field, value: Any) -> str:
    if field.type == "text16":
        return json.dumps(value)
    if field.type == "f32":
        return f"{float(value).hex()}f"
    if field.type == "i32" and value == -(2**31):
        return "INT32_MIN"
    return f"{value}" + ("u" if field.type.startswith("u") else "")


def group(vector: dict[str, Any]) -> tuple[str, tuple[Field, ...], str]:
    """Name of the struct, its fields, and the call that writes the header."""
    kind, name = vector["kind"], vector["name"]
    if kind == "event":
        message: Message = SPEC.events[name]
        code = f"WIRE_EVENT_{name.upper()}_CODE"
        return f"event_{name}", message.fields, f"wire_put_event_header(buffer + 1, {code})"
    message, code = SPEC.commands[name], f"WIRE_{name.upper()}_CODE"
    if kind == "command":
        head = f"wire_put_command_header(buffer + 1, {code}, {vector['request']}u)"
        return name, message.fields, head
    status = f"WIRE_STATUS_{vector['status'].upper()}"
    head = f"wire_put_reply_header(buffer + 1, {code}, {vector['request']}u, {status})"
    return f"{name}_reply", message.reply if vector["status"] == "ok" else (), head


def equal(field: Field) -> str:
    if field.type == "text16":
        return f"memcmp(got.{field.name}, m.{field.name}, 16) == 0"
    return f"got.{field.name} == m.{field.name}"


def check(number: int, vector: dict[str, Any]) -> str:
    """A C function that writes the vector's payload, compares, and reads it back.

    The payload begins at an odd address, so that an unaligned access would show.
    """
    struct, fields, head = group(vector)
    payload = bytes.fromhex(vector["payload"])
    values = {f.name: 0 for f in fields if f.since} | vector["fields"]  # an older minor's vector
    samples = values.pop("samples") if vector["name"] == "sample_block" else []
    values["count"] = len(samples)
    lines = [
        f"static int check_{number}(void) {{ /* {vector['kind']} {vector['name']} */",
        f"    static const uint8_t wire[] = {{{', '.join(map(str, payload))}}};",
        "    uint8_t buffer[1 + WIRE_MAX_PAYLOAD] = {0};",
        f"    size_t at = 1 + {head};",
    ]
    if fields:
        inits = ", ".join(f".{f.name} = {literal(f, values[f.name])}" for f in fields)
        lines += [
            f"    const wire_{struct}_t m = {{{inits}}};",
            f"    wire_{struct}_t got;",
            "    const size_t begin = at;",
            f"    at += wire_put_{struct}(buffer + at, &m);",
            f"    CHECK(at - begin == WIRE_{struct.upper()}_SIZE);",
            f"    CHECK(wire_get_{struct}(buffer + begin, sizeof wire + 1 - begin, &got));",
            *(f"    CHECK({equal(field)});" for field in fields),
            f"    CHECK(wire_get_{struct}(buffer + begin, at - begin + 1, &got));",
            f"    CHECK(!wire_get_{struct}(buffer + begin, {required_size(fields)}u - 1u, &got));",
        ]
    for sample in (value for row in samples for value in row):
        lines += [
            f"    wire_put_i16(buffer + at, {sample});",
            f"    CHECK(wire_get_i16(buffer + at) == {sample});",
            "    at += 2;",
        ]
    lines += [
        "    CHECK(at - 1 >= sizeof wire);",
        "    CHECK(memcmp(buffer + 1, wire, sizeof wire) == 0);",
        "    return 0;",
        "}\n",
    ]
    return "\n".join(lines)


def program() -> str:
    checks = "\n".join(check(number, vector) for number, vector in enumerate(VECTORS))
    calls = " || ".join(f"check_{number}()" for number in range(len(VECTORS)))
    return f"{HEAD}\n{checks}\nint main(void) {{ return {calls}; }}\n"


@pytest.mark.slow
def test_c_and_python_write_and_read_the_same_bytes(tmp_path: Path) -> None:
    source, binary = tmp_path / "vectors.c", tmp_path / "vectors"
    source.write_text(program(), encoding="utf-8")
    run(compiler("gcc"), *FLAGS, *UNDEFINED, f"-I{CORE}", str(source), "-o", str(binary))
    assert run(str(binary)) == ""


@pytest.mark.slow
def test_a_wrong_byte_fails_the_c_check(tmp_path: Path) -> None:
    source, binary = tmp_path / "wrong.c", tmp_path / "wrong"
    source.write_text(program().replace("wire[] = {1,", "wire[] = {2,", 1), encoding="utf-8")
    run(compiler("gcc"), *FLAGS, f"-I{CORE}", str(source), "-o", str(binary))
    done = subprocess.run([str(binary)], capture_output=True, text=True)
    assert done.returncode == 1
    assert "memcmp" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("chip", ["atmega328p", "atmega2560"])
def test_header_compiles_for_eight_bits(tmp_path: Path, chip: str) -> None:
    source = tmp_path / "vectors.c"
    source.write_text(program(), encoding="utf-8")
    target = tmp_path / "vectors.o"
    avr = compiler("avr-gcc")
    run(avr, f"-mmcu={chip}", "-Os", *FLAGS, f"-I{CORE}", "-c", str(source), "-o", str(target))


def test_header_sizes_are_the_specifications() -> None:
    header = (CORE / "wire_gen.h").read_text(encoding="utf-8")
    assert f"#define WIRE_COMMAND_HEADER {COMMAND_HEADER}u" in header
    assert f"#define WIRE_REPLY_HEADER {REPLY_HEADER}u" in header
    assert f"#define WIRE_EVENT_HEADER {EVENT_HEADER}u" in header
    assert "#define WIRE_START_STATES 0x08u" in header
    assert "#define WIRE_STOP_STATES 0x7Fu" in header


@pytest.mark.slow
def test_fields_of_a_later_minor_read_as_zero_in_c(tmp_path: Path) -> None:
    text = PATH.read_text(encoding="utf-8").replace("minor = 3", "minor = 4", 1)
    old = '["samples", "u16", "", "readings to average (1 to 4096)"]'
    assert old in text
    newer = parse(
        text.replace(old, old + ', ["more", "u32", "", "", 4], ["t", "text16", "", "", 4]')
    )
    (tmp_path / "wire_gen.h").write_text(render_c.render(newer), encoding="utf-8")
    source, binary = tmp_path / "newer.c", tmp_path / "newer"
    source.write_text(
        HEAD
        + """
int main(void) {
    const uint8_t wire[23] = {7, 0, 4, 3, 2, 1, 'a'};
    wire_zero_t m;
    CHECK(!wire_get_zero(wire, 1, &m));
    CHECK(wire_get_zero(wire, 2, &m) && m.samples == 7 && m.more == 0 && m.t[0] == 0);
    CHECK(wire_get_zero(wire, 6, &m) && m.more == 0x01020304 && m.t[0] == 0);
    CHECK(wire_get_zero(wire, 22, &m) && m.more == 0x01020304 && m.t[0] == 'a');
    return 0;
}
""",
        encoding="utf-8",
    )
    run(compiler("gcc"), *FLAGS, *UNDEFINED, f"-I{tmp_path}", str(source), "-o", str(binary))
    assert run(str(binary)) == ""
