"""Records of a journal made by hand: what a host asked, what its board answered and said."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from motorid.acquire.assemble import Assembler
from motorid.acquire.journal import MAGIC, Kind, Record, encode_record
from motorid.program import Decay, Program, Step, StepKind
from motorid.wire.codec import channel_mask, encode_command, encode_event, encode_reply
from motorid.wire.enums import Channel, ChannelKind, EndReason, Status
from motorid.wire.framing import encode
from motorid.wire.spec import load

CHANNELS = (Channel.CURRENT, Channel.POSITION)
PERIOD, SAMPLES = 1000, 8  # ticks of a clock of 1 MHz; samples that were asked for
PROGRAM = Program(
    (Step(StepKind.COAST, 0.002), Step(StepKind.DRIVE_VOLTS, 0.006, 3.0, Decay.SYNCHRONOUS_SLOW))
)
HEADER = {
    "program": PROGRAM.to_dict(),
    "wiring": {"counts_per_turn": 400.0},
    "rig_name": "bench",
    "note": "by hand",
    "ambient_c": 21.5,
    "ambient_uncertainty_c": 0.5,
    "zero_samples": 1,
}
IDENTITY = {
    "board": "bench", "clock_hz": 1_000_000, "pwm_hz": 20_000, "dead_time_ns": 1500,
    "clock_uncertainty_ppm": 300, "min_sample_period_ticks": 500,
}  # fmt: skip
CURRENT_FACT = {
    "channel": Channel.CURRENT, "kind": ChannelKind.MEAN, "scale": 0.5, "offset": 3.0,
    "raw_min": -512, "raw_max": 511, "noise": 0.75, "pwm_phase_permille": 250,
}  # fmt: skip
POSITION_FACT = {"channel": Channel.POSITION, "kind": ChannelKind.INSTANT, "scale": 1.0}
CONFIG = {"sample_period_ticks": PERIOD, "channels": channel_mask(CHANNELS)}
ZERO = {"current_offset": 4.0, "current_noise": 0.5}


def sent(name: str, request: int, at_s: float = 0.0, **fields: Any) -> Record:
    wanted = {one.name: 0 for one in load().commands[name].fields} | fields
    return Record(Kind.SENT, at_s, encode(encode_command(name, request, **wanted)))


def came(payload: bytes, at_s: float = 0.0) -> Record:
    return Record(Kind.RECEIVED, at_s, encode(payload))


def reply(
    name: str, request: int, status: Status = Status.OK, at_s: float = 0.0, **fields: Any
) -> Record:
    blank = {one.name: "" if one.type == "text16" else 0 for one in load().commands[name].reply}
    return came(encode_reply(name, request, status, **(blank | fields)), at_s)


def asked(name: str, request: int, **fields: Any) -> list[Record]:
    return [sent(name, request), reply(name, request, **fields)]


def event(name: str, **fields: Any) -> Record:
    blank = {one.name: 0 for one in load().events[name].fields}
    return came(encode_event(name, **(blank | fields)))


def block(
    number: int, *readings: int, channels: tuple[Channel, ...] = CHANNELS, **facts: Any
) -> Record:
    """Readings from sample ``number`` on; the encoder counts on by one a sample."""
    columns = [readings, range(number, number + len(readings))][: len(channels)]
    fields = {
        "sequence": 0, "first_tick": number * PERIOD, "dropped": 0, "position": number,
        "channels": channel_mask(channels), "samples": np.array(columns, np.int16).T,
    } | facts  # fmt: skip
    return came(encode_event("sample_block", **fields))


def mark(**what: Any) -> Record:
    return Record(Kind.MARK, 0.0, json.dumps(what).encode())


def done(reason: EndReason = EndReason.COMPLETED, **fields: Any) -> Record:
    return event("done", reason=reason, **fields)


BEFORE = [
    *asked("identify", 1, **IDENTITY),
    *asked("describe_channel", 2, **CURRENT_FACT),
    *asked("describe_channel", 3, **POSITION_FACT),
    *asked("read_config", 4, **CONFIG),
    *asked("zero", 5, **ZERO),
]
BEGUN = [
    *BEFORE,
    mark(measure=True, samples=SAMPLES, wire_steps=[0, 1, 1], check={"duty": 0.1}),
    *asked("start", 6, start_tick=0),
]


def assembled(*records: Record, **header: Any) -> Assembler:
    made = Assembler(HEADER | header)
    for one in records:
        made.feed(one)
    return made


def written(path: Path, *records: Record, tail: bytes = b"", **header: Any) -> bytes:
    """Writes a journal of these records, and what is torn at its end; returns its bytes."""
    first = Record(Kind.HEADER, 0.0, json.dumps(HEADER | header).encode())
    data = b"".join(encode_record(one.kind, one.time_s, one.data) for one in (first, *records))
    path.write_bytes(MAGIC + data + tail)
    return path.read_bytes()
