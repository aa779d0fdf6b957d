"""What recovery promises of any journal: the capture that it holds, or one sentence."""

from __future__ import annotations

import copy
import functools
import io
import tempfile
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import numpy as np

from motorid.acquire import record
from motorid.acquire.assemble import Assembler, assemble
from motorid.acquire.journal import MAGIC, JournalReader, Kind, Record, encode_record, parse_journal
from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.wire.framing import Decoder, Frame, encode
from motorid.wire.spec import load
from tests.acquire.rigs import sim_rig
from tests.fuzz.sentence import check_sentence

RAW, AFTER, FRAMED = 0, 1, 2  # ways of reading an input, by its first byte


def check(data: bytes) -> None:
    """Raises where a journal breaks a promise."""
    way, rest = (data[0] % 3 if data else RAW), data[1:]
    try:
        capture = _read(rest) if way == RAW else _go_on(way, rest)
    except DataError as error:
        check_sentence(str(error), len(data))
        return
    assert np.all(np.diff(capture.ticks) > 0)
    assert 0 < len(capture) <= 120 * len(data)  # a sample takes two bytes, a frame holds 240
    assert all(len(channel.raw) == len(capture) for channel in capture.channels.values())
    assert sum(gap.samples for gap in capture.gaps) < 2**32


def _read(data: bytes) -> Capture:
    """The capture of a whole journal."""
    parsed = parse_journal(data)
    assert 0 <= parsed.torn <= len(data)
    return assemble(JournalReader(io.BytesIO(data), len(data)))


def _go_on(way: int, data: bytes) -> Capture:
    """The capture of a run that begins well, and of which this is what the board sent.

    As it is, or as the payloads of good frames, each after a byte with its length.
    """
    assembler: Assembler = copy.deepcopy(_beginning()[0])
    if way == AFTER:
        assembler.feed(Record(Kind.RECEIVED, 1.0, data))
    while way == FRAMED and len(data) > 1:
        size = min(1 + data[0] % load().max_payload, len(data) - 1)
        assembler.feed(Record(Kind.RECEIVED, 1.0, encode(data[1 : size + 1])))
        data = data[size + 1 :]
    return assembler.capture()


@functools.lru_cache(maxsize=1)
def _beginning() -> tuple[Assembler, bytes]:
    """A simulated run up to its first sample, and all that the board sent in it."""

    class Kept(record.JournalWriter):
        """A journal that stays."""

        def discard(self) -> None:
            """Leaves the file."""

    rig = sim_rig()
    with tempfile.TemporaryDirectory() as folder, mock.patch.object(record, "JournalWriter", Kept):
        record.capture(rig, rig.program, Path(folder, "run.h5"))
        journal = parse_journal(Path(folder, "run.h5.journal").read_bytes())
    begin = next(n for n, one in enumerate(journal.records) if b"measure" in one.data) + 1
    assembler = Assembler(journal.header)
    for one in journal.records[:begin]:
        assembler.feed(one)
    return assembler, b"".join(r.data for r in journal.records[begin:] if r.kind is Kind.RECEIVED)


def seeds() -> Iterator[bytes]:
    """A short journal as it is, and pieces of what a board sends in a run."""
    head = MAGIC + encode_record(Kind.HEADER, 0, b'{"rig_name": "x"}')
    yield bytes([RAW]) + head + encode_record(Kind.MARK, 1, b'{"a": 1}')
    sent = Decoder().feed(_beginning()[1][:8000])
    frames = [one.payload for one in sent if isinstance(one, Frame)]
    for n in range(0, len(frames), 4):
        some = frames[n : n + 4]
        yield bytes([AFTER]) + b"".join(encode(payload) for payload in some)
        yield bytes([FRAMED]) + b"".join(bytes([len(one) - 1]) + one for one in some)
