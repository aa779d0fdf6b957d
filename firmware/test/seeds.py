"""Writes a corpus for the fuzzer into a folder: every command of the vectors, and whole runs."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from vectors import VECTORS

FRAMED, LONG_TURN = b"\x01", 0x80
PERIOD = 1600


def entry(payload: bytes, turn: int = 0) -> bytes:
    """A payload as fuzz_receive.c reads it."""
    return bytes([len(payload) - 1 | turn]) + payload


def number(value: int, size: int = 4) -> bytes:
    return value.to_bytes(size, "little", signed=value < 0)


def run() -> bytes:
    """configure, two steps, start with hashes that a fuzzer cannot guess, heartbeat, stop."""
    from zlib import crc32

    limits = (4000, 100_000, 5000, 15_000, 60_000)
    config = number(PERIOD) + bytes([11, 0, 0]) + b"".join(map(number, limits)) + number(500, 2)
    steps = [
        bytes([0, 1, 1]) + number(500_000) + number(20 * PERIOD),
        bytes([1, 0, 0]) + number(0) + number(30 * PERIOD),
    ]
    hashes = number(crc32(config)) + number(crc32(b"".join(steps)))
    commands = [(3, config), (6, steps[0]), (6, steps[1]), (7, hashes), (9, b"\0\0"), (8, b"")]
    entries = [
        entry(bytes([code]) + number(request, 2) + fields, LONG_TURN * (code >= 7))
        for request, (code, fields) in enumerate(commands, 1)
    ]
    return FRAMED + b"".join(entries)


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    vectors = json.loads(VECTORS.read_text(encoding="utf-8"))
    commands = [bytes.fromhex(v["payload"]) for v in vectors if v["kind"] == "command"]
    for index, payload in enumerate(commands):
        (folder / f"command{index}").write_bytes(FRAMED + entry(payload))
    for index, vector in enumerate(vectors):
        (folder / f"raw{index}").write_bytes(b"\0" + bytes.fromhex(vector["frame"]))
    (folder / "run").write_bytes(run())


if __name__ == "__main__":
    main()
