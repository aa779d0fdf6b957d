"""Writes the frames of tests/wire/vectors.json as a C header to standard output."""

from __future__ import annotations

import json
import sys
from pathlib import Path

VECTORS = Path(__file__).resolve().parents[2] / "tests" / "wire" / "vectors.json"


def literal(text: str) -> str:
    return "(const uint8_t[]){" + ", ".join(str(byte) for byte in bytes.fromhex(text)) + "}"


def main() -> None:
    vectors = json.loads(VECTORS.read_text(encoding="utf-8"))
    lines = [
        "/* Generated from tests/wire/vectors.json: do not edit. */",
        "#include <stdint.h>",
        "static const struct vector {",
        "    const uint8_t *payload;",
        "    uint16_t length;",
        "    const uint8_t *frame;",
        "    uint16_t size;",
        "} vectors[] = {",
    ]
    for vector in vectors:
        payload, frame = vector["payload"], vector["frame"]
        sizes = len(payload) // 2, len(frame) // 2
        lines.append(f"    {{{literal(payload)}, {sizes[0]}, {literal(frame)}, {sizes[1]}}},")
    lines += ["};", f"enum {{ vector_count = {len(vectors)} }};"]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
