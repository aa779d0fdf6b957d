"""A journal that a capture left behind: in nobody's way for long, and never lost."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from motorid.acquire import leftover, record
from motorid.acquire.assemble import NoSamplesError
from motorid.acquire.journal import journal_path, read_journal
from motorid.acquire.journal_writer import JournalWriter
from motorid.capture import store
from motorid.cli.main import run
from motorid.errors import UsageError
from tests.acquire.rigs import sim_rig


def left(folder: Path, *, size: int | None = None) -> Path:
    """The journal of a run that was killed, cut to ``size`` bytes if given; it is old."""
    rig, path = sim_rig(), folder / "run.h5"

    class Kept(JournalWriter):
        def discard(self) -> None:
            """Leaves the file."""

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(record, "JournalWriter", Kept)
        record.capture(rig, rig.program, path)
    path.unlink()
    journal = journal_path(path)
    if size is not None:
        os.truncate(journal, size)
    os.utime(journal, (time.time() - 60, time.time() - 60))
    return journal


@pytest.mark.slow
def test_a_journal_without_samples_frees_its_name_and_is_kept(tmp_path: Path) -> None:
    journal = left(tmp_path, size=6000)
    before = journal.read_bytes()
    with pytest.raises(NoSamplesError, match=r"it is run\.h5\.journal\.empty now") as caught:
        record.recover(journal)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 4
    assert (tmp_path / "run.h5.journal.empty").read_bytes() == before
    rig = sim_rig()
    assert len(store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))) == 3800


@pytest.mark.slow
def test_force_moves_a_leftover_aside_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    journal = left(tmp_path)
    before = journal.read_bytes()
    words = ["capture", "--rig", "sim", "--speed", "max", "-o", str(tmp_path / "run.h5")]
    assert run(words) == 2
    refused = capsys.readouterr().err
    assert "motorid recover" in refused
    assert "--force" in refused
    assert run([*words, "--force"]) == 0
    assert "it is run.h5.journal.old now" in capsys.readouterr().err
    aside = tmp_path / "run.h5.journal.old"
    assert aside.read_bytes() == before
    assert run(["recover", str(aside)]) == 0
    assert len(store.load(tmp_path / "run.old.h5")) == 3800
    assert not aside.exists()


@pytest.mark.slow
def test_force_into_a_folder_does_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old = tmp_path / "capture.h5.journal"
    left(tmp_path).rename(old)
    words = ["run", "--rig", "sim", "--speed", "max", "-o", str(tmp_path), "--force"]
    assert run(words) == 0
    assert "it is capture.h5.journal.old now" in capsys.readouterr().err
    assert (tmp_path / "capture.h5").exists()


@pytest.mark.slow
def test_force_leaves_a_live_journal_alone(tmp_path: Path) -> None:
    """Its capture may have written nothing for a while."""
    path = tmp_path / "run.h5"
    writer = JournalWriter(journal_path(path), {"rig_name": "other"})
    os.utime(journal_path(path), (time.time() - 60, time.time() - 60))
    rig = sim_rig()
    with pytest.raises(UsageError, match="is still being written"):
        record.capture(rig, rig.program, path, force=True)
    with pytest.raises(UsageError, match="is still being written"):
        record.recover(path)
    writer.close()
    assert read_journal(journal_path(path)).header == {"rig_name": "other"}
    assert len(store.load(record.capture(rig, rig.program, path, force=True))) == 3800


def test_where_no_lock_tells_growth_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = journal_path(tmp_path / "run.h5")
    path.write_bytes(b"x")
    monkeypatch.setattr(leftover, "is_free", lambda _: None)
    monkeypatch.setattr(leftover.time, "sleep", lambda _: path.write_bytes(b"xy"))
    with pytest.raises(UsageError, match="is still being written"):
        leftover.refuse_growing(path)
    leftover.refuse_growing(path)


def test_no_name_is_taken_twice(tmp_path: Path) -> None:
    for content in (b"1", b"2", b"3"):
        (tmp_path / "run.h5.journal").write_bytes(content)
        leftover.set_aside(tmp_path / "run.h5.journal", "old")
    found = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert found == {
        "run.h5.journal.old": b"1",
        "run.h5.journal.old-2": b"2",
        "run.h5.journal.old-3": b"3",
    }


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("run.h5.journal", "run.h5"),
        ("run.h5.journal.old", "run.old.h5"),
        ("run.h5.journal.torn-2", "run.torn-2.h5"),
        ("a.journal.h5.journal", "a.journal.h5"),
    ],
)
def test_a_journal_says_what_it_was_for(name: str, target: str) -> None:
    assert leftover.is_journal(Path(name))
    assert leftover.target_of(Path(name)) == Path(target)


def test_a_capture_is_no_journal() -> None:
    assert not leftover.is_journal(Path("my.journal.h5"))
    assert not leftover.is_journal(Path("run.h5"))
