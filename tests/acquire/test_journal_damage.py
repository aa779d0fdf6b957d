"""Damage in a journal told from a missing end: where a good record is looked for, and how far."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import pytest

from motorid.acquire import journal_check
from motorid.acquire.journal import MAGIC, Kind, encode_record
from motorid.acquire.journal_check import JournalState, Wholeness, check_journal, state_of
from motorid.errors import DataError

START = MAGIC + encode_record(Kind.HEADER, 0, b"{}")
AT = len(START)
UNENDED = b"R" + bytes(8) + struct.pack("<I", 10_000)  # of which the rest never came
GOOD = encode_record(Kind.RECEIVED, 1.5, b"some bytes")


def whole(data: bytes) -> Wholeness:
    found = state_of(START + data)
    assert found.whole in (Wholeness.CUT, Wholeness.DAMAGED)
    assert found.at == AT
    return found.whole


def head(length: int) -> bytes:
    """What may begin a record, and does not: its time is beyond all time."""
    return b"S" + b"z" * 8 + struct.pack("<I", length)


@pytest.mark.parametrize("before", [0, 1, 200])
@pytest.mark.parametrize("after", [b"", b"z" * 5, b"z" * 100], ids=len)
@pytest.mark.parametrize("good", [GOOD, encode_record(Kind.MARK, 0, b"")], ids=len)
def test_a_good_record_behind_a_bad_one_is_damage(before: int, after: bytes, good: bytes) -> None:
    assert whole(UNENDED + b"z" * before + good + after) is Wholeness.DAMAGED
    spoilt = good[:-1] + bytes([good[-1] ^ 0x55])
    assert whole(UNENDED + b"z" * before + spoilt + after) is Wholeness.CUT


def test_a_byte_too_many_before_a_good_record_is_damage() -> None:
    assert whole(b"z" + GOOD) is Wholeness.DAMAGED
    assert whole(b"zzzz") is Wholeness.CUT


@pytest.mark.parametrize(("filler", "kind"), [(44, Wholeness.DAMAGED), (45, Wholeness.CUT)])
def test_it_is_looked_for_as_far_as_the_longest_record_reaches(
    filler: int, kind: Wholeness, monkeypatch: pytest.MonkeyPatch
) -> None:
    # the first place is one byte behind the bad one's; from it to the good one 12 + 44 = 39 + 17
    monkeypatch.setattr(journal_check, "LONGEST_RECORD", 39)
    assert whole(UNENDED + b"z" * filler + GOOD + b"z" * 30) is kind


@pytest.mark.parametrize(("length", "kind"), [(1, Wholeness.DAMAGED), (2, Wholeness.CUT)])
def test_the_bytes_that_are_tried_are_those_of_four_records(
    length: int, kind: Wholeness, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So that hostile bytes cannot make the search long: three tries leave 160 - 159 = 1."""
    monkeypatch.setattr(journal_check, "LONGEST_RECORD", 40)
    good = encode_record(Kind.RECEIVED, 1.5, b"abc"[:length])
    assert whole(UNENDED + 3 * head(53) + good + b"z" * 80) is kind
    too_long = head(10_000)  # beyond the end: it costs nothing
    monkeypatch.setattr(journal_check, "LONGEST_RECORD", 60)
    assert whole(UNENDED + 3 * too_long + good + b"z" * 80) is Wholeness.DAMAGED


def record(data: bytes, check: int | None = None) -> bytes:
    body = b"R" + bytes(8) + struct.pack("<I", len(data)) + data
    return body + struct.pack("<I", zlib.crc32(body) if check is None else check)


@pytest.mark.parametrize(("zeros", "kind"), [(16, Wholeness.CUT), (15, Wholeness.DAMAGED)])
def test_sixteen_zeros_stand_for_a_missing_end(zeros: int, kind: Wholeness) -> None:
    data = record(b"x" * 100)
    found = state_of(START + data[:-zeros] + bytes(zeros))
    assert (found.whole, found.at) == (kind, AT)
    assert found.why == (
        "zeros in place of its end" if kind is Wholeness.CUT else "a record fails its check"
    )


def test_zeros_behind_a_whole_record_that_is_wrong_do_not_excuse_it() -> None:
    wrong = record(b"x" * 40, check=0x01010101)
    assert whole(wrong + bytes(40)) is Wholeness.DAMAGED
    assert whole(wrong[:-1] + bytes(41)) is Wholeness.CUT  # its last byte may be missing


@pytest.mark.parametrize("rest", [1, 16])
def test_fewer_bytes_than_a_record_s_least_are_a_missing_end(rest: int) -> None:
    found = state_of(START + b"R" + b"z" * (rest - 1))
    assert found == JournalState(Wholeness.CUT, AT, f"{rest} bytes of a record")


def test_as_many_bytes_as_a_record_s_least_are_a_record() -> None:
    assert whole(record(b"", check=1)) is Wholeness.DAMAGED


def test_a_last_record_of_which_only_the_length_is_wrong_is_damage() -> None:
    for data in (b"", b"some bytes"):
        good = encode_record(Kind.SENT, 2.0, data)
        assert whole(good[:9] + struct.pack("<I", 5000) + good[13:]) is Wholeness.DAMAGED
        assert whole(good[:9] + struct.pack("<I", 5000) + good[13:-1] + b"?") is Wholeness.CUT


# -- of a file
def test_a_file_s_state_is_its_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.journal"
    path.write_bytes(b"")
    assert check_journal(path) == JournalState(Wholeness.CUT, 0, "it ends in its first line")
    path.write_bytes(START)
    assert check_journal(path) == JournalState(Wholeness.OPEN, AT)
    with pytest.raises(DataError, match=r"absent"):
        check_journal(tmp_path / "absent")


@pytest.mark.parametrize("error", [OSError(5, "the disk fails"), ValueError("the disk fails")])
def test_a_file_that_cannot_be_read_says_why(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*words: Any, **more: Any) -> None:
        raise error

    path = tmp_path / "a.journal"
    path.write_bytes(START)
    monkeypatch.setattr(journal_check.mmap, "mmap", fails)
    with pytest.raises(DataError, match=r"a\.journal: cannot be read: the disk fails$"):
        check_journal(path)
