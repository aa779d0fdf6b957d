"""What becomes of a journal that is recovered, by what it holds; the locks and names in its way."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import journal_place, keep, leftover, lock
from motorid.acquire.assemble import NoPlaceError, NoSamplesError
from motorid.acquire.journal import Kind, encode_record
from motorid.acquire.keep import Kept, recover
from motorid.acquire.leftover import make_way, refuse_growing, set_aside
from motorid.capture import store
from motorid.errors import DataError, UsageError
from tests.acquire.journals import BEGUN, block, done, written

RUN = (*BEGUN, block(0, 4, 6, 8, 10), block(4, 12, 14, 16, 18), done())
CLOSED = encode_record(Kind.MARK, 0, b'{"closed": {"bytes": 1, "sha256": ""}}')  # of another one


@pytest.fixture(autouse=True)
def unsynced(monkeypatch: pytest.MonkeyPatch) -> None:
    """No test here is about a power failure."""
    monkeypatch.setattr(os, "fsync", lambda handle: None)


def names(folder: Path) -> list[str]:
    return sorted(one.name for one in folder.iterdir())


@pytest.mark.parametrize(
    ("records", "tail", "stays"),
    [
        (RUN, b"", []),
        (RUN, b"R123", ["run.h5.journal.torn"]),
        (RUN, CLOSED, ["run.h5.journal.torn"]),
        ((*RUN[:-1], block(4, 1, first_tick=4001), done()), b"", ["run.h5.journal.raw"]),
        ((*RUN[:-1], block(4, 1, first_tick=4001), done()), b"R123", ["run.h5.journal.raw"]),
    ],
    ids=("whole", "torn", "altered", "unplaced", "unplaced and torn"),
)
def test_a_journal_goes_once_all_of_it_is_in_the_capture(
    records: Any, tail: bytes, stays: list[str], tmp_path: Path
) -> None:
    before = written(tmp_path / "run.h5.journal", *records, tail=tail)
    by = "run.h5.journal" if stays else "run.h5"
    assert recover(tmp_path / by) == tmp_path / "run.h5"
    assert len(store.load(tmp_path / "run.h5")) == 8
    assert names(tmp_path) == ["run.h5", *stays]
    assert all((tmp_path / name).read_bytes() == before for name in stays)


def test_a_journal_without_a_sample_gives_its_name_back(tmp_path: Path) -> None:
    journal = tmp_path / "run.h5.journal"
    before = written(journal, *BEGUN)
    with pytest.raises(
        NoSamplesError, match=r"^/.*\.journal: not one .*; it is run\.h5\.journal\.e"
    ):
        recover(journal)
    assert (tmp_path / "run.h5.journal.empty").read_bytes() == before
    written(journal, *BEGUN, block(0, 1, first_tick=500), block(0, 1, first_tick=1))
    says = r"^/.*\.journal: not one sample has a place.*; they are kept as they came in /.*\.raw$"
    with pytest.raises(NoPlaceError, match=says):
        recover(journal)
    assert names(tmp_path) == ["run.h5.journal.empty", "run.h5.journal.raw"]


def test_a_capture_that_is_there_stays(tmp_path: Path) -> None:
    written(tmp_path / "run.h5.journal", *RUN)
    (tmp_path / "run.h5").write_bytes(b"mine")
    with pytest.raises(UsageError, match=r"run\.h5 exists"):
        recover(tmp_path / "run.h5")
    assert (tmp_path / "run.h5").read_bytes() == b"mine"
    assert len(names(tmp_path)) == 2


@pytest.mark.slow
def test_what_is_kept_is_counted(tmp_path: Path) -> None:
    journal = tmp_path / "run.h5.journal"
    written(journal, *RUN)
    assert keep.keep(journal, tmp_path / "a.h5") == Kept(8, False, False)
    written(journal, *RUN[:-2], block(4, 1, first_tick=4001), tail=b"R")
    assert keep.keep(journal, tmp_path / "b.h5") == Kept(4, True, True)
    with pytest.raises(UsageError, match=r"exists.*the run is in .*journal: `motorid recover /"):
        keep.keep(journal, tmp_path / "a.h5")
    assert keep.keep(journal, tmp_path / "a.h5", force=True).samples == 4


@pytest.mark.parametrize(
    ("error", "target", "says"),
    [
        (DataError("full"), "run.h5", r"^full; the run is in J: `motorid recover` builds the c"),
        (DataError("full"), "a.h5", r"^full; the run is in J: `motorid recover J` builds the c"),
        (UsageError("no"), "run.h5", r"^no; the run is in J"),
        (
            ValueError("odd"),
            "run.h5",
            r"^this run makes no capture file \(odd\): it is in J, as it",
        ),
    ],
)
def test_a_capture_that_cannot_be_written_says_where_the_run_is(
    error: Exception, target: str, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*words: object) -> None:
        raise error

    journal = tmp_path / "run.h5.journal"
    written(journal, *RUN)
    monkeypatch.setattr(keep.store, "save", fails)
    kind = DataError if isinstance(error, ValueError) else type(error)
    with pytest.raises(kind) as e:
        keep.keep(journal, tmp_path / target)
    assert e.match(says.replace("J", str(journal)))


def test_a_capture_that_cannot_be_read_back_is_set_aside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(path: Path) -> None:
        raise DataError("no capture")

    written(tmp_path / "run.h5.journal", *RUN)
    monkeypatch.setattr(keep.store, "load", fails)
    with pytest.raises(
        DataError, match=r"^no capture; what is there is run\.h5\.bad now: the disk"
    ):
        keep.keep(tmp_path / "run.h5.journal", tmp_path / "run.h5")
    assert names(tmp_path) == ["run.h5.bad", "run.h5.journal"]


# -- who still writes it
def test_a_journal_that_is_written_is_left_alone(tmp_path: Path) -> None:
    journal = tmp_path / "run.h5.journal"
    written(journal, *RUN)
    if lock.is_free(journal) is None:
        return
    assert lock.is_free(journal) is True
    with journal.open("rb+") as file:
        assert lock.hold(file) is True
        assert lock.is_free(journal) is False
        for refused in (recover, make_way):
            with pytest.raises(UsageError, match="is still being written: let that capture finish"):
                refused(journal if refused is recover else tmp_path / "run.h5")  # type: ignore[operator]
        assert names(tmp_path) == ["run.h5.journal"]
    assert make_way(tmp_path / "run.h5") == (
        f"an earlier run left {journal}: it is run.h5.journal.old now, for `motorid recover`"
    )
    assert make_way(tmp_path / "run.h5") == ""
    assert names(tmp_path) == ["run.h5.journal.old"]


@pytest.mark.parametrize("absent", [True, False])
def test_a_system_that_cannot_lock_says_nothing(
    absent: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*words: object) -> None:
        raise OSError(45, "not supported")

    made = SimpleNamespace(flock=fails, LOCK_EX=1, LOCK_NB=2)
    monkeypatch.setitem(sys.modules, "fcntl", None if absent else made)
    path = tmp_path / "file"
    path.write_bytes(b"")
    assert lock.is_free(path) is None


@pytest.mark.parametrize(
    ("age_s", "grows", "free", "slept"),
    [(2.0, 5, True, []), (1.0, 0, True, [1.5]), (1.0, 5, False, [1.5]), (1.4, 5, False, [1.5])],
)
def test_without_locks_a_file_that_grows_is_written(
    age_s: float, grows: int, free: bool, slept: list[float], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    journal, waits = tmp_path / "run.h5.journal", list[float]()
    journal.write_bytes(b"12345")

    def sleep(seconds: float) -> None:
        waits.append(seconds)
        journal.write_bytes(b"12345" + bytes(grows))

    now = journal.stat().st_mtime + age_s
    monkeypatch.setattr(leftover, "is_free", lambda path: None)
    monkeypatch.setattr(leftover, "time", SimpleNamespace(time=lambda: now, sleep=sleep))
    if free:
        refuse_growing(journal)
    else:
        with pytest.raises(UsageError, match="still being written"):
            refuse_growing(journal)
    assert waits == slept


def test_what_a_disk_refuses_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*words: object) -> None:
        raise OSError(5, "the disk fails")

    journal = tmp_path / "run.h5.journal"
    with pytest.raises(DataError, match=r"\.journal cannot be renamed: No such file"):
        set_aside(journal, "old")
    monkeypatch.setattr(leftover, "is_free", fails)
    with pytest.raises(DataError, match=r"\.journal: cannot be read: the disk fails$"):
        refuse_growing(journal)


# -- a journal whose name is taken from it
def failing(times: int) -> Callable[[int], None]:
    """An fsync that fails so often."""
    known, left = os.fsync, [times]

    def sync(handle: int) -> None:
        left[0] -= 1
        if left[0] >= 0:
            raise OSError(28, "No space left on device")
        known(handle)

    return sync


def test_a_copy_goes_to_the_next_place_that_takes_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copies: list[Any] = []
    create = journal_place.create
    path = tmp_path / "gone" / "too" / "run.journal"
    path.parent.mkdir(parents=True)
    file = create(path)
    file.write(b"what was written")
    path.unlink()
    path.parent.rmdir()
    path.parent.parent.rmdir()

    def creates(place: Path) -> Any:
        copies.append(create(place))
        return copies[-1]

    sync = SimpleNamespace(**vars(os) | {"fsync": failing(1)})
    monkeypatch.setattr(journal_place, "create", creates)
    monkeypatch.setattr(journal_place, "os", sync)
    copy, place = journal_place.copy_elsewhere(file, path)
    assert place == path.with_name("run.journal.kept")
    assert names(path.parent) == ["run.journal.kept"]
    assert place.read_bytes() == b"what was written"
    assert [one.closed for one in copies] == [True, False]
    assert file.closed
    assert journal_place.is_named(copy, place)
    assert lock.is_free(place) in (False, None)  # nobody else may write it
    copy.close()


def test_a_file_stays_open_where_nothing_takes_a_copy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.journal"
    with journal_place.create(path) as file:
        file.write(b"some")
        monkeypatch.setattr(journal_place, "_names", lambda path: iter([path, tmp_path / "b"]))
        monkeypatch.setattr(
            journal_place, "os", SimpleNamespace(**vars(os) | {"fsync": failing(9)})
        )
        with pytest.raises(OSError, match="No space left"):
            journal_place.copy_elsewhere(file, path)
        file.write(b"thing")
        file.flush()
        assert path.read_bytes() == b"something"
    assert names(tmp_path) == ["run.journal"]


def test_a_system_that_does_not_say_where_a_name_leads_is_believed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stat(error: OSError) -> Any:
        def fails(path: Path) -> None:
            raise error

        return SimpleNamespace(**vars(os) | {"stat": fails})

    with journal_place.create(tmp_path / "a") as file:
        assert journal_place.is_named(file, tmp_path / "a")
        (tmp_path / "b").write_bytes(b"")
        assert not journal_place.is_named(file, tmp_path / "b")
        assert not journal_place.is_named(file, tmp_path / "c")
        assert not journal_place.is_named(file, tmp_path / "b" / "c")
        monkeypatch.setattr(journal_place, "os", stat(PermissionError(13, "denied")))
        assert journal_place.is_named(file, tmp_path / "a")
