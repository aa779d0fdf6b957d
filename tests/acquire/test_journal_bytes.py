"""A journal's bytes, one place changed at a time; and the blocks of a run on its line of time."""

from __future__ import annotations

import hashlib
import struct
import zlib
from typing import Any

import numpy as np
import pytest

from motorid import json_text
from motorid.acquire import journal_check
from motorid.acquire.journal import MAGIC, Digest, Kind, encode_record, parse_journal
from motorid.acquire.journal_check import Wholeness, state_of
from motorid.acquire.timeline import DROPPED, LOST, MISSING_END, OUTSIDE, TAKEN, Timeline
from motorid.capture.model import Gap, Phase
from motorid.errors import DataError
from motorid.wire.codec import SampleBlock
from motorid.wire.enums import Channel

HEADER = encode_record(Kind.HEADER, 0, b'{"a": 1}')
DATA = encode_record(Kind.RECEIVED, 1.5, b"some bytes")
WHOLE = MAGIC + HEADER + DATA


def closed(data: bytes, **changes: Any) -> bytes:
    said = {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()} | changes
    return data + encode_record(Kind.MARK, 0, json_text.dumps({"closed": said}).encode())


def test_a_record_is_kind_nanoseconds_length_data_and_check_sum() -> None:
    body = b"R" + struct.pack("<QI", 1_500_000_000, 10) + b"some bytes"
    assert body + struct.pack("<I", zlib.crc32(body)) == DATA
    assert encode_record(Kind.SENT, -3.0, b"")[1:9] == bytes(8)  # no time lies before 0


def test_a_closing_mark_holds_the_size_and_the_digest_of_all_before_it() -> None:
    digest = Digest()
    assert digest.add(MAGIC + HEADER) == MAGIC + HEADER
    assert WHOLE + digest.closing(DATA) == closed(WHOLE)
    assert MAGIC + HEADER + digest.closing(b"") == closed(MAGIC + HEADER)  # it added nothing


@pytest.mark.parametrize(
    ("data", "whole", "at"),
    [
        (closed(WHOLE), Wholeness.SOUND, len(closed(WHOLE))),
        (WHOLE, Wholeness.OPEN, len(WHOLE)),
        (closed(WHOLE, bytes=5), Wholeness.DAMAGED, len(WHOLE)),
        (closed(WHOLE, sha256="0"), Wholeness.DAMAGED, len(WHOLE)),
        (MAGIC[:5], Wholeness.CUT, 5),
        (b"", Wholeness.CUT, 0),
        (MAGIC, Wholeness.CUT, len(MAGIC)),
        (b"motorid journal 2\n", Wholeness.DAMAGED, 0),
        (WHOLE[:-1], Wholeness.CUT, len(MAGIC + HEADER)),
        (WHOLE + b"R" + bytes(12), Wholeness.CUT, len(WHOLE)),  # fewer than a record's least
        (WHOLE + bytes(40), Wholeness.CUT, len(WHOLE)),  # zeros in place of its end
        (WHOLE[:-20] + bytes(20), Wholeness.CUT, len(MAGIC + HEADER)),
        (WHOLE[:-1] + b"\1", Wholeness.DAMAGED, len(MAGIC + HEADER)),  # all bytes, a wrong check
        (WHOLE[:-15] + b"X" + WHOLE[-14:], Wholeness.DAMAGED, len(MAGIC + HEADER)),
    ],
)
def test_what_is_known_of_a_journal(data: bytes, whole: Wholeness, at: int) -> None:
    found = state_of(data)
    assert (found.whole, found.at) == (whole, at)


def test_a_wrong_length_is_damage_and_no_missing_end() -> None:
    at = len(MAGIC + HEADER)
    longer = DATA[:9] + struct.pack("<I", 11) + DATA[13:]
    assert state_of(MAGIC + HEADER + longer).whole is Wholeness.DAMAGED
    missing = encode_record(Kind.RECEIVED, 1.5, b"some bytes more")[:-1]
    found = state_of(MAGIC + HEADER + missing)
    assert (found.whole, found.why) == (Wholeness.CUT, f"{len(missing)} bytes of a record")
    assert state_of(MAGIC + HEADER + longer + DATA).whole is Wholeness.DAMAGED
    assert state_of(MAGIC + HEADER + missing + DATA).at == at


@pytest.mark.parametrize(("nanoseconds", "good"), [(10**18, True), (10**18 + 1, False)])
def test_a_record_of_another_century_is_none(nanoseconds: int, good: bool) -> None:
    body = b"R" + struct.pack("<QI", nanoseconds, 1) + b"x"
    record = body + struct.pack("<I", zlib.crc32(body))
    assert journal_check._good(record, 0) == (len(record) if good else 0)
    assert journal_check._good(b"Q" + record[1:], 0) == 0
    assert journal_check._good(record[:-1], 0) == 0
    assert journal_check._good(b"zz" + record, 2) == (len(record) if good else 0)


def test_zeros_at_an_end_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal_check, "_BLOCK", 3)
    assert [journal_check._zeros(b"\1" + bytes(n), 0) for n in (0, 1, 2, 3, 7)] == [0, 1, 2, 3, 7]
    assert journal_check._zeros(bytes(7), 2) == 5
    assert journal_check._sha256(b"abcdefgh", 5) == hashlib.sha256(b"abcde").hexdigest()


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "it is empty, so delete it"), (MAGIC[:7], "it is empty, so delete it"),
        (b"else", "not a motorid journal, or damaged in its first line"),
        (MAGIC + HEADER[:12], "ends before its header"), (MAGIC, "ends before its header"),
        (MAGIC + HEADER[:-1], "ends before its header"),
        (MAGIC + HEADER[:-4], "ends before its header"),
        (MAGIC + HEADER[:-5], "ends before its header"),
        (MAGIC + DATA, "header is damaged"), (MAGIC + HEADER[:-1] + b"\1", "header is damaged"),
    ],
)  # fmt: skip
def test_what_does_not_begin_as_a_journal(data: bytes, says: str) -> None:
    with pytest.raises(DataError, match=says):
        parse_journal(data)


def test_a_reader_passes_over_the_closing_mark_and_counts_what_is_torn() -> None:
    mark = encode_record(Kind.MARK, 2.0, b'{"measure": true}')
    found = parse_journal(closed(WHOLE + mark) + b"torn")
    assert [one.kind for one in found.records] == [Kind.RECEIVED, Kind.MARK]
    assert [one.time_s for one in found.records] == [1.5, 2.0]
    assert (found.header, found.torn) == ({"a": 1}, 4)


# -- blocks on a line of time
PERIOD = 10


def block(first: int, count: int, dropped: int = 0, value: int = 1) -> SampleBlock:
    samples = np.full((count, 1), value, np.int16)
    return SampleBlock(0, first % 2**32, dropped, 0, (Channel.CURRENT,), samples)


def line(*blocks: SampleBlock, start: int | None = 100, samples: int | None = None) -> Timeline:
    made = Timeline(PERIOD, samples)
    if start is not None:
        made.start(start)
    for one in blocks:
        made.add(one)
    return made


def test_what_is_missing_is_what_the_board_dropped_and_what_the_link_lost() -> None:
    made = line(block(100, 2), block(170, 1, dropped=2), block(200, 1, dropped=9))
    gaps = made.arrays().gaps
    assert gaps == (Gap(2, 2, DROPPED), Gap(2, 3, LOST), Gap(3, 2, DROPPED))
    gaps = made.arrays(taken=14, dropped=5).gaps  # four came, seven are known to lack
    assert gaps[3:] == (Gap(4, 1, DROPPED), Gap(4, 2, MISSING_END))
    assert made.arrays(taken=11, dropped=9).gaps == gaps[:3]
    assert made.arrays(taken=5).gaps == gaps[:3]


@pytest.mark.parametrize(("start", "missing"), [(100, 3), (130, 0), (None, 0), (135, 0), (140, 0)])
def test_what_is_missing_before_the_first_block(start: int | None, missing: int) -> None:
    made = line(start=None)
    if start is not None:
        made._begin = start
    made.blocks.append(130, block(130, 2))
    assert made.arrays().gaps == ((Gap(0, missing, LOST),) if missing else ())


@pytest.mark.parametrize(
    ("first", "count", "good"), [(110, 4, True), (140, 1, True), (140, 2, False), (90, 1, False)]
)
def test_a_run_has_so_many_samples(first: int, count: int, good: bool) -> None:
    made = line(block(100, 1), block(first, count), samples=5)
    assert len(made.arrays().ticks) == 1 + (count if good else 0)
    assert made.unplaced == ({} if good else {OUTSIDE: count})


def test_a_block_within_another_is_a_repeat_only_where_it_says_the_same() -> None:
    made = line(block(100, 3), block(130, 3, value=2), block(110, 2), block(140, 1, value=5))
    made.add(block(120, 2))  # which reaches into the second
    assert len(made.arrays().ticks) == 6
    assert made.repeated == 1
    assert made.unplaced == {TAKEN: 3}
    assert made.impossible == 2


def test_late_blocks_take_their_places_in_time() -> None:
    made = line(
        block(100, 1, value=1),
        block(150, 1, value=6),
        block(120, 2, value=3),
        block(110, 1, value=2),
    )
    found = made.arrays()
    assert found.ticks.tolist() == [100, 110, 120, 130, 150]
    assert found.columns["current"].tolist() == [1, 2, 3, 3, 6]
    assert found.gaps == (Gap(4, 1, LOST),)


def test_phases_are_of_the_run_s_ticks_and_come_once() -> None:
    made = line(block(2**32 - 20, 2), start=2**32 - 20)
    for index, tick in ((0, 2**32 - 20), (1, 0), (1, 0), (2, 5), (3, 20)):
        made.phase(index, tick)
    assert made.phases == [Phase(0, 2**32 - 20), Phase(1, 2**32), Phase(3, 2**32 + 20)]
