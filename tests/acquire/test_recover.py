"""What a journal gives back: the same file, or what it holds, or one sentence."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.acquire import assemble, leftover, record
from motorid.acquire.journal import Kind, encode_record, journal_path, parse_journal
from motorid.acquire.live import Live
from motorid.capture import store
from motorid.errors import DataError, LinkError
from motorid.wire.codec import Reply, encode_reply
from motorid.wire.enums import Status
from motorid.wire.framing import encode
from tests.acquire.rigs import SAMPLES, run, sim_rig


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_replay_gives_the_same_file(tmp_path: Path) -> None:
    path = run("seed=5&fault=flip:2e-4", tmp_path / "live.h5")
    rig = replace(sim_rig(), port=f"replay://{journal_path(path)}")
    again = record.capture(rig, rig.program, tmp_path / "again.h5")
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_torn_journal_replays_as_it_recovers(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    data = journal_path(path).read_bytes()
    torn = tmp_path / "torn.h5"
    journal_path(torn).write_bytes(data[: 3 * len(data) // 4])
    rig = replace(sim_rig(), port=f"replay://{journal_path(torn)}")
    with pytest.raises(LinkError, match="the journal ends here"):
        record.capture(rig, rig.program, tmp_path / "again.h5")
    record.recover(torn)
    assert (tmp_path / "again.h5").read_bytes() == torn.read_bytes()


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_recovery_gives_the_same_file(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    live = path.read_bytes()
    path.unlink()
    assert record.recover(journal_path(path)) == path
    assert path.read_bytes() == live
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_journal_that_was_altered_after_it_was_closed_stays(tmp_path: Path) -> None:
    """Every record of it is good, and one is missing."""
    path = run("", tmp_path / "run.h5")
    data = journal_path(path).read_bytes()
    records = parse_journal(data).records
    last = max(
        (r for r in records if r.kind is Kind.RECEIVED and len(r.data) > 20), key=lambda r: r.time_s
    )
    record_bytes = encode_record(last.kind, last.time_s, last.data)
    assert data.count(record_bytes) == 1
    journal_path(path).write_bytes(data.replace(record_bytes, b""))
    path.unlink()
    assert record.recover(path) == path
    assert sorted(one.name for one in tmp_path.iterdir()) == ["run.h5", "run.h5.journal.torn"]


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_torn_journal_gives_what_it_holds(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    whole = store.load(path)
    data = journal_path(path).read_bytes()
    for share in (0.6, 0.8, 0.95):
        target = tmp_path / f"{share}.h5"
        journal_path(target).write_bytes(data[: int(share * len(data))])
        capture = store.load(record.recover(target))
        assert capture.end_reason == "interrupted"
        assert "ended early" in record.missing(capture)
        n = len(capture)
        assert 0 < n < SAMPLES
        for name, channel in capture.channels.items():
            np.testing.assert_array_equal(channel.raw, whole.channels[name].raw[:n])


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_journal_without_a_sample_says_so(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    found = parse_journal(journal_path(path).read_bytes())
    early = tmp_path / "early.h5.journal"
    whole = journal_path(path).read_bytes()
    head = whole[: whole.index(b'"measure"') - 20]
    early.write_bytes(head)
    with pytest.raises(DataError, match="not one sample"):
        record.recover(early)
    assert any(r.kind is Kind.MARK and "measure" in r.json for r in found.records)
    assert not (tmp_path / "early.h5").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_hostile_journal_is_one_sentence(tmp_path: Path) -> None:
    path = run("", tmp_path / "run.h5")
    found = parse_journal(journal_path(path).read_bytes())
    tail = b"".join(encode_record(r.kind, r.time_s, r.data) for r in found.records)
    for number, header in enumerate([b"{}", b'{"program": 3}', b'{"wiring": {"x": 1}}']):
        bad = tmp_path / f"bad{number}.h5.journal"
        bad.write_bytes(b"motorid journal 1\n" + encode_record(Kind.HEADER, 0, header) + tail)
        with pytest.raises(DataError) as caught:
            record.recover(bad)
        assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_full_disk_stops_the_motor_and_keeps_what_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The journal's disk fills in mid-run; room is made; the journal holds the beginning."""
    full, begun, refused = threading.Event(), threading.Event(), threading.Event()
    fsync = os.fsync

    def sync(handle: int) -> None:
        if begun.is_set():
            refused.set()
            raise OSError(28, "No space left on device")
        if full.is_set():  # of what was there before the first samples; the next has those
            begun.set()
        fsync(handle)

    monkeypatch.setattr("motorid.acquire.journal_writer.os.fsync", sync)
    monkeypatch.setattr("motorid.acquire.journal_writer.SYNC_S", 0.0)
    rig = sim_rig()

    def fill(live: Live) -> None:
        full.set()
        assert refused.wait(60)

    with pytest.raises(DataError, match=r"No space left.*the motor was stopped"):
        record.capture(rig, rig.program, tmp_path / "run.h5", progress=fill)
    assert not (tmp_path / "run.h5").exists()
    begun.clear()
    full.clear()
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    capture = store.load(record.recover(tmp_path / "run.h5"))
    assert 0 < len(capture) < SAMPLES


@pytest.mark.slow
def test_no_room_for_the_file_keeps_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    def no_name(sibling: Path, path: Path) -> None:
        full(0)

    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    with monkeypatch.context() as patch:
        patch.setattr("motorid.capture.whole.os.replace", no_name)
        patch.setattr("motorid.capture.whole.os.link", no_name)
        patch.setattr("motorid.capture.whole.os.rename", no_name)
        with pytest.raises(DataError, match=r"cannot be written.*motorid recover"):
            run("", tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == [tmp_path / "run.h5.journal"]
    assert len(store.load(record.recover(tmp_path / "run.h5"))) == SAMPLES


WRONG = (3, -1, 1e308, float("nan"), True, None, "x", "\ud800", [1], {"a": 1}, {"a": {"b": []}})


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_whatever_a_header_or_a_mark_holds_costs_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every value of either, and every value within these, in turn as something else."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)  # hundreds of files that nobody keeps
    rig = sim_rig()
    rig = replace(rig, sampling=replace(rig.sampling, rate_hz=1000))
    record.capture(rig, rig.program, tmp_path / "run.h5", serial="M1", note="x")
    found = parse_journal(journal_path(tmp_path / "run.h5").read_bytes())
    marks = {n: r.json for n, r in enumerate(found.records) if r.kind is Kind.MARK}
    said: set[bool] = set()
    for number, mark in [(-1, dict(found.header)), *marks.items()]:
        for changed in variants(mark):
            new = json.dumps(changed).encode()
            header = new if number < 0 else json.dumps(found.header).encode()
            records = [
                encode_record(r.kind, r.time_s, new if n == number else r.data)
                for n, r in enumerate(found.records)
            ]
            head = b"motorid journal 1\n" + encode_record(Kind.HEADER, 0, header)
            journal = tmp_path / "changed.h5.journal"
            journal.write_bytes(head + b"".join(records))
            try:
                target = record.recover(journal)
            except DataError as error:
                assert "\n" not in str(error)  # noqa: PT017 - either way is right
                said.add(False)
                assert [one for one in tmp_path.iterdir() if one.name.startswith("changed.h5.j")]
            else:
                said.add(True)
                assert len(store.load(target)) > 0
            for one in tmp_path.glob("changed*"):
                one.unlink()
    assert said == {True, False}


def variants(value: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """The object with one thing in it wrong."""
    for key, inner in value.items():
        for wrong in WRONG[len(key) % 5 :: 5]:
            yield value | {key: wrong}
        if isinstance(inner, dict):
            for changed in variants(inner):
                yield value | {key: changed}


@pytest.mark.slow
def test_offsets_that_are_no_numbers_are_the_board_s_nominal_ones(tmp_path: Path) -> None:
    """In a journal of an earlier version, which drove such a board all the same."""
    known = assemble.decode

    def lying(payload: bytes) -> Any:
        message = known(payload)
        if isinstance(message, Reply) and message.name == "zero":
            return replace(message, fields=message.fields | {"current_noise": float("nan")})
        return message

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(assemble, "decode", lying)
        path = run("", tmp_path / "run.h5")
    capture = store.load(path)
    assert capture.provenance["zero"] == {}
    assert any("nominal offsets" in remark for remark in record.remarks(capture))


@pytest.mark.slow
@pytest.mark.usefixtures("keep_journal")
def test_a_reply_that_nobody_asked_for_changes_nothing(tmp_path: Path) -> None:
    """The client of the board takes none; nor does who reads the journal later."""
    path = run("", tmp_path / "run.h5")
    found = parse_journal(journal_path(path).read_bytes())
    records = []
    for one in found.records:
        records.append(one)
        if one.kind is Kind.RECEIVED:
            stray = {"current_offset": 1.0, "current_noise": 2.0}
            stray |= {"voltage_offset": 3.0, "voltage_noise": 4.0}
            payload = encode_reply("zero", 9, Status.OK, **stray)
            records.append(replace(one, data=b"\0" + encode(payload)))
    head = b"motorid journal 1\n"
    head += encode_record(Kind.HEADER, 0, json.dumps(found.header).encode())
    again = journal_path(tmp_path / "again.h5")
    whole = b"".join(encode_record(r.kind, r.time_s, r.data) for r in records)
    again.write_bytes(head + whole)
    capture = store.load(record.recover(again))
    assert capture.provenance["zero"] == store.load(path).provenance["zero"]
    assert len(capture) > 0.9 * len(store.load(path))  # a frame between reads is cut by it
