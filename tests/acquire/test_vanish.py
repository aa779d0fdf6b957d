"""A journal whose name or folder is removed while it is written, and outputs that cannot be."""

from __future__ import annotations

import errno
import os
import shutil
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.acquire import journal_place, journal_writer, keep, leftover, outputs, record
from motorid.acquire.journal import Kind, journal_path, read_journal
from motorid.acquire.journal_writer import JournalWriter
from motorid.capture import store, whole
from motorid.capture.model import Capture
from motorid.errors import DataError, MotoridError, UsageError
from tests.acquire.rigs import SAMPLES, run, sim_rig


def acting(act: Callable[[], None]) -> Callable[[Any], None]:
    """A progress that acts once, in mid-run."""
    done: list[bool] = []

    def on(live: Any) -> None:
        if not done:
            done.append(True)
            act()

    return on


def capture_while(act: Callable[[], None], path: Path) -> Path:
    rig = sim_rig()
    return record.capture(rig, rig.program, path, progress=acting(act))


@pytest.fixture(autouse=True)
def elsewhere(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The home and the temporary folder of these tests."""
    home = tmp_path_factory.mktemp("home")
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setattr(journal_place, "gettempdir", lambda: str(home))
    return home


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows removes no open file")
@pytest.mark.parametrize("what", ["journal", "folder"])
def test_what_is_removed_in_mid_run_costs_nothing(what: str, tmp_path: Path) -> None:
    path = tmp_path / "runs" / "run.h5"
    path.parent.mkdir()

    def remove() -> None:
        if what == "journal":
            journal_path(path).unlink()
        else:
            shutil.rmtree(path.parent)

    assert capture_while(remove, path) == path
    assert len(store.load(path)) == SAMPLES
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows removes no open file")
def test_a_folder_that_stays_away_names_another(
    tmp_path: Path, elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file stands where the folder was: neither journal nor capture have a place there."""
    path = tmp_path / "runs" / "run.h5"
    path.parent.mkdir()

    def replace_folder() -> None:
        shutil.rmtree(path.parent)
        path.parent.write_text("in the way")

    kept = elsewhere / "run.h5.journal"
    with pytest.raises(MotoridError) as caught:
        capture_while(replace_folder, path)
    assert f"the run is in {kept}: `motorid recover {kept}` builds the capture" in str(caught.value)
    assert caught.value.exit_code in (2, 4)
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    assert len(store.load(record.recover(kept))) == SAMPLES


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="Windows removes no open file")
def test_a_name_that_another_file_took_is_left_to_it(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    journal = journal_path(path)

    def take() -> None:
        journal.unlink()
        journal.write_text("somebody else's")

    capture_while(take, path)
    assert len(store.load(path)) == SAMPLES
    assert journal.read_text() == "somebody else's"
    assert sorted(tmp_path.iterdir()) == [path, journal]


@pytest.mark.skipif(os.name == "nt", reason="Windows removes no open file")
def test_the_copy_is_made_in_mid_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So that a host that dies afterwards leaves it."""
    monkeypatch.setattr(journal_writer, "SYNC_S", 0.0)
    writer = JournalWriter(tmp_path / "run.h5.journal", {"note": "x"})
    writer.append(Kind.RECEIVED, 1.0, b"before")
    while len(read_journal(writer.path).records) < 1:
        time.sleep(1e-3)
    writer.path.unlink()
    writer.append(Kind.RECEIVED, 2.0, b"after")
    while not writer.path.exists() or len(read_journal(writer.path).records) < 2:
        time.sleep(1e-3)
    assert [one.data for one in read_journal(writer.path).records] == [b"before", b"after"]
    writer.close()


@pytest.mark.skipif(os.name == "nt", reason="Windows removes no open file")
def test_no_place_at_all_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> Any:
        raise OSError(errno.EROFS, "Read-only file system")

    writer = JournalWriter(tmp_path / "run.h5.journal", {})
    monkeypatch.setattr(journal_place, "create", refuse)
    writer.path.unlink()
    writer.append(Kind.RECEIVED, 1.0, b"x")
    with pytest.raises(DataError, match="Read-only file system"):
        writer.close()


# ---------------------------------------------------------------- before the motor moves


def refused(path: Path, *, force: bool = False, **changes: Any) -> str:
    """What a capture to ``path`` is refused with; nothing may be driven for it."""
    rig = replace(sim_rig(), **changes)

    def opened(url: str) -> Any:
        raise AssertionError("the port was opened")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(record, "open_port", opened)
        with pytest.raises((UsageError, DataError)) as caught:
            record.capture(rig, rig.program, path, force=force)
    return str(caught.value)


def test_a_link_that_leads_nowhere_is_in_the_way(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.symlink_to(tmp_path / "nowhere" / "x.h5")
    assert "exists already" in refused(path)
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_in_the_way_is_said_first(tmp_path: Path) -> None:
    assert "is a folder" in refused(tmp_path)
    assert "does not exist" in refused(tmp_path / "away" / "run.h5")
    (tmp_path / "run.h5.journal").write_text("")
    assert "motorid recover" in refused(tmp_path / "run.h5")
    assert "name too long" in refused(tmp_path / ("x" * 245 + ".h5"))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such files")
def test_force_replaces_files_and_nothing_else(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.h5")
    assert "no ordinary file" in refused(tmp_path / "run.h5", force=True)


def test_a_folder_that_takes_no_file_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(handle: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(whole.os, "fsync", full)
    assert "No space left" in refused(tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_the_disk_does_not_hold_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(tmp_path)
    monkeypatch.setattr(outputs.shutil, "disk_usage", lambda folder: usage._replace(free=50_000))
    said = refused(tmp_path / "run.h5")
    assert "make room" in said
    assert str(tmp_path) in said


def test_a_run_longer_than_a_capture_may_be_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store, "CAPTURE", replace(store.CAPTURE, rows=100))
    assert "samples are more than a capture may have" in refused(tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_planned_size_is_enough_and_not_much_more(tmp_path: Path) -> None:
    rig = sim_rig()
    captured, journal = outputs.planned_bytes(rig, rig.program)
    sizes: list[int] = []

    def note(self: JournalWriter) -> None:
        sizes.append(self.path.stat().st_size)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(JournalWriter, "discard", note)
        path = run("", tmp_path / "run.h5")
    whole_run = 0.5 * SAMPLES  # what every file has, whatever its length, is not planned for
    assert path.stat().st_size < captured + 50_000 < 3 * path.stat().st_size + whole_run
    assert sizes[0] < journal + 50_000


# ---------------------------------------------------------------- read back


@pytest.mark.slow
def test_a_file_that_reads_back_otherwise_keeps_the_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    load = store.load

    def flipped(path: Path) -> Capture:
        found = load(path)
        current = found.channels["current"]
        raw = np.array(current.raw)
        raw[100] ^= 1
        return replace(found, channels={**found.channels, "current": replace(current, raw=raw)})

    path = tmp_path / "run.h5"
    with monkeypatch.context() as patch:
        patch.setattr(keep.store, "load", flipped)
        with pytest.raises(DataError, match=r"reads back otherwise.*motorid recover"):
            run("", path)
    assert sorted(tmp_path.iterdir()) == [path.with_name("run.h5.bad"), journal_path(path)]
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    assert len(store.load(record.recover(path))) == SAMPLES


@pytest.mark.slow
@pytest.mark.parametrize("missing", ["unlink", "truncate"])
def test_a_file_that_is_not_there_afterwards_keeps_the_journal(
    missing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save = store.save

    def lost(capture: Capture, path: Path, force: bool = False) -> Path:
        save(capture, path, force)
        path.unlink()
        if missing == "truncate":
            path.write_bytes(b"")
        return path

    path = tmp_path / "run.h5"
    with monkeypatch.context() as patch:
        patch.setattr(keep.store, "save", lost)
        with pytest.raises(DataError, match=r"the run is in .*motorid recover"):
            run("", path)
    monkeypatch.setattr(leftover, "STILL_GROWING_S", 0.0)
    assert len(store.load(record.recover(path))) == SAMPLES
