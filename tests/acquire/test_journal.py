"""The journal: whole, torn, refused by the disk, or cut by a power failure."""

from __future__ import annotations

import io
import math
import os
import queue
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, BinaryIO, ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.acquire import journal_writer as room
from motorid.acquire.journal import (
    MAGIC,
    Kind,
    encode_record,
    journal_path,
    parse_journal,
    read_journal,
)
from motorid.acquire.journal_check import JournalState, Wholeness, state_of
from motorid.acquire.journal_writer import JournalWriter
from motorid.errors import DataError, UsageError

LONG_S = 60.0  # after which a thread that has not acted never will
HEAD = MAGIC + encode_record(Kind.HEADER, 0, b'{"rig_name": "x"}')


def test_what_is_appended_is_read(tmp_path: Path) -> None:
    path = journal_path(tmp_path / "run.h5")
    writer = JournalWriter(path, {"rig_name": "sim", "note": "Ω"})
    writer.append(Kind.SENT, 1.25, b"\0ask")
    writer.mark(1.5, measure=True)
    writer.append(Kind.RECEIVED, 2.0, b"answer\0")
    writer.close()
    found = read_journal(path)
    assert path.name == "run.h5.journal"
    assert found.header == {"rig_name": "sim", "note": "Ω"}
    assert [(r.kind, r.time_s) for r in found.records] == [
        (Kind.SENT, 1.25),
        (Kind.MARK, 1.5),
        (Kind.RECEIVED, 2.0),
    ]
    assert found.records[0].data == b"\0ask"
    assert found.records[1].json == {"measure": True}
    assert found.torn == 0


def test_a_torn_tail_costs_only_the_last_record() -> None:
    records = [encode_record(Kind.RECEIVED, n, bytes([n]) * 9) for n in range(5)]
    whole = HEAD + b"".join(records)
    ends = [len(HEAD) + sum(map(len, records[:n])) for n in range(6)]
    for cut in range(len(HEAD), len(whole) + 1):
        found = parse_journal(whole[:cut])
        kept = max(n for n in range(6) if ends[n] <= cut)
        assert len(found.records) == kept
        assert found.torn == cut - ends[kept]


def test_an_empty_record_at_the_end_is_whole() -> None:
    data = MAGIC + encode_record(Kind.HEADER, 0.0, b"{}") + encode_record(Kind.SENT, 1.0, b"")
    assert state_of(data) == JournalState(Wholeness.OPEN, len(data))
    assert state_of(data[:-1]).whole is Wholeness.CUT


def test_a_damaged_record_ends_the_journal() -> None:
    first, second = (encode_record(Kind.RECEIVED, n, b"abcdef") for n in range(2))
    bad = bytearray(second)
    bad[15] ^= 1
    found = parse_journal(HEAD + first + bytes(bad) + first)
    assert len(found.records) == 1
    assert found.torn == len(second) + len(first)


@pytest.mark.parametrize(
    "data",
    [b"", b"motorid", MAGIC, b"\x89HDF\r\n", HEAD[:-1], MAGIC + encode_record(Kind.SENT, 0, b"x")],
)
def test_what_is_no_journal_is_said(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.journal"
    path.write_bytes(data)
    with pytest.raises(DataError, match="journal"):
        read_journal(path)


def test_a_header_that_is_no_object_is_said() -> None:
    with pytest.raises(DataError, match="damaged"):
        parse_journal(MAGIC + encode_record(Kind.HEADER, 0, b"[1]"))


@pytest.mark.slow
@given(st.binary(max_size=300))
def test_any_tail_is_read_or_left_out(tail: bytes) -> None:
    found = parse_journal(HEAD + tail)
    read = sum(len(encode_record(r.kind, r.time_s, r.data)) for r in found.records)
    assert read + found.torn == len(tail)


@pytest.mark.slow
@given(st.lists(st.tuples(st.sampled_from([Kind.SENT, Kind.RECEIVED]), st.binary(max_size=40))))
def test_any_records_come_back(records: list[tuple[Kind, bytes]]) -> None:
    found = parse_journal(HEAD + b"".join(encode_record(k, 0.5, d) for k, d in records))
    assert [(r.kind, r.data) for r in found.records] == records


def test_one_journal_has_one_writer(tmp_path: Path) -> None:
    path = tmp_path / "run.h5.journal"
    writer = JournalWriter(path, {})
    with pytest.raises(UsageError, match="another capture"):
        JournalWriter(path, {})
    writer.close()
    with pytest.raises(UsageError, match="motorid recover"):
        JournalWriter(path, {})


def test_a_closed_journal_is_sound_and_goes_once(tmp_path: Path) -> None:
    path = tmp_path / "run.h5.journal"
    for count in (0, 3):
        writer = JournalWriter(path, {})
        for number in range(count):
            writer.append(Kind.RECEIVED, float(number), b"data")
        writer.close()
        data = path.read_bytes()
        assert state_of(data) == JournalState(Wholeness.SOUND, len(data))
        assert len(read_journal(path).records) == count
        writer.discard()
        writer.discard()
        assert not path.exists()


def test_no_thread_is_left(tmp_path: Path) -> None:
    before = threading.active_count()
    writer = JournalWriter(tmp_path / "a", {})
    assert threading.active_count() == before + 1
    writer.close()
    writer.close()
    assert threading.active_count() == before


class FullDisk(io.FileIO):
    """A file on a disk that takes the header and a little more."""

    room = 500

    def write(self, data: Any) -> int:
        if self.tell() + len(data) > self.room:
            raise OSError(28, "No space left on device")
        return super().write(data)


def open_full(path: Path) -> BinaryIO:
    return io.BufferedWriter(FullDisk(str(path), "xb"))


def test_a_full_disk_is_told_to_the_reader(tmp_path: Path) -> None:
    path = tmp_path / "run.h5.journal"
    before = threading.active_count()
    writer = JournalWriter(path, {}, open_file=open_full)

    def fill() -> None:
        for _ in range(1000):
            writer.append(Kind.RECEIVED, 0, bytes(100))
            time.sleep(1e-3)

    with pytest.raises(DataError, match=r"No space left.*motorid recover"):
        fill()
    with pytest.raises(DataError, match="No space left"):
        writer.close()
    assert threading.active_count() == before
    assert read_journal(path).header == {}


def test_a_disk_that_is_full_from_the_start_leaves_nothing(tmp_path: Path) -> None:
    path, opened = tmp_path / "run.h5.journal", list[BinaryIO]()

    def open_noted(path: Path) -> BinaryIO:
        opened.append(open_full(path))
        return opened[0]

    with pytest.raises(DataError, match="cannot be written"):
        JournalWriter(path, {"note": "x" * 1000}, open_file=open_noted)
    assert not path.exists()
    assert opened[0].closed


class Watched(queue.SimpleQueue[Any]):
    """A queue that notes how long its reader was willing to wait."""

    waits: ClassVar[list[float]] = []

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        self.waits.append(math.inf if timeout is None else timeout)
        return super().get(block, timeout)


def test_written_in_100_ms_and_synced_in_a_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a crash and what a power failure leave: by the waits that the writer asks for, and by a
    clock that stands still, so that a busy computer changes nothing.
    """
    path = tmp_path / "run.h5.journal"
    now, synced, fsync = [0.0], threading.Event(), os.fsync

    def note_sync(handle: int) -> None:
        fsync(handle)
        synced.set()

    monkeypatch.setattr(room.os, "fsync", note_sync)
    monkeypatch.setattr(room, "time", SimpleNamespace(monotonic=lambda: now[0], sleep=time.sleep))
    monkeypatch.setattr(room.queue, "SimpleQueue", Watched)
    Watched.waits.clear()
    writer = JournalWriter(path, {})
    synced.clear()
    writer.append(Kind.RECEIVED, 1.0, b"data")
    until(lambda: [record.time_s for record in read_journal(path).records] == [1.0])
    assert not synced.is_set()
    now[0] += 1.0 - 0.1  # the last wait before it ends within the second
    assert synced.wait(LONG_S)
    writer.close()
    assert max(Watched.waits) <= 0.1


def until(done: Callable[[], bool]) -> None:
    """Waits for the writer's thread, however busy the computer."""
    patience = threading.Event()
    for _ in range(int(LONG_S / 0.01)):
        if done():
            return
        patience.wait(0.01)
    raise AssertionError("the writer did nothing")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_writer_that_died_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever it died of: the capture ends, and the motor with it."""
    monkeypatch.setattr(room, "BACKLOG", 2)
    monkeypatch.setattr(JournalWriter, "_copy", lambda self: 1 / 0)
    writer = JournalWriter(tmp_path / "run.journal", {})
    for _ in range(room.BACKLOG):
        writer.append(Kind.RECEIVED, 0.0, b"x")
    with pytest.raises(DataError, match="no longer written"):
        writer.append(Kind.RECEIVED, 0.0, b"x")
