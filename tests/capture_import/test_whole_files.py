"""Files appear whole or not at all: what is synced when, and what stands in the way."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motorid.capture.whole import check_writable, refuse_existing, sync_folder, write_whole
from motorid.errors import DataError, UsageError

DATA = b"some data"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "run.h5"


Synced = list[tuple[str, int, bool]]


@pytest.fixture
def synced(path: Path, monkeypatch: pytest.MonkeyPatch) -> Synced:
    """Of each sync: folder or file, its size then, and whether the file had its name by then."""
    found: Synced = []

    def note(handle: int) -> None:
        known = os.fstat(handle)
        folder = stat.S_ISDIR(known.st_mode)
        size = 0 if folder else known.st_size
        found.append(("folder" if folder else "file", size, path.exists()))

    monkeypatch.setattr(os, "fsync", note)
    return found


def fails(error: OSError) -> Callable[..., Any]:
    def fail(*_: Any, **__: Any) -> Any:
        raise error

    return fail


def names(folder: Path) -> list[str]:
    return sorted(os.listdir(folder))


def test_data_are_synced_before_they_have_their_name_and_the_name_after(
    path: Path, synced: Synced
) -> None:
    write_whole(path, DATA)
    assert synced == [("file", len(DATA), False), ("folder", 0, True)]
    assert path.read_bytes() == DATA
    assert names(path.parent) == ["run.h5"]


def test_only_force_replaces_a_file(path: Path) -> None:
    path.write_bytes(b"mine")
    for refused in (write_whole, lambda p, _: check_writable(p)):
        with pytest.raises(UsageError, match=r"run\.h5 exists already: .*--force"):
            refused(path, DATA)
    assert path.read_bytes() == b"mine"
    check_writable(path, force=True)
    assert path.read_bytes() == b"mine"
    write_whole(path, DATA, force=True)
    assert path.read_bytes() == DATA
    assert names(path.parent) == ["run.h5"]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows knows no such modes")
def test_who_may_read_a_file_is_the_callers_choice(path: Path) -> None:
    write_whole(path, DATA, mode=0o600)
    assert path.stat().st_mode & 0o777 == 0o600
    mask = os.umask(0)
    os.umask(mask)
    write_whole(path, DATA, force=True)
    assert path.stat().st_mode & 0o777 == 0o666 & ~mask


@pytest.mark.parametrize(
    ("error", "says"),
    [(OSError(errno.ENOSPC, "No space left"), r"\(No space left\)"), (OSError("odd"), r"\(odd\)")],
)
def test_a_disk_that_refuses_is_one_sentence_and_leaves_nothing(
    error: OSError, says: str, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "fsync", fails(error))
    with pytest.raises(DataError, match=rf"run\.h5 cannot be written {says}: nothing was put"):
        write_whole(path, DATA)
    with pytest.raises(DataError, match=rf"run\.h5 cannot be written {says}$"):
        check_writable(path)
    assert names(path.parent) == []


def test_a_trial_writes_a_block_that_a_full_disk_has_not(path: Path, synced: Synced) -> None:
    check_writable(path)
    assert synced == [("file", 4096, False)]
    assert names(path.parent) == []


# -- the name
def test_the_sibling_is_hidden_and_of_this_process(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[Path] = []
    monkeypatch.setattr(os, "link", lambda a, b: seen.append(Path(a)) or Path(b).write_bytes(b"x"))
    write_whole(path, DATA)
    assert seen == [path.parent / f".run.h5.{os.getpid()}.tmp"]
    assert names(path.parent) == ["run.h5"]


def test_who_got_there_first_keeps_the_name(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    link = os.link

    def late(a: Path, b: Path) -> None:
        Path(b).write_bytes(b"theirs")
        link(a, b)

    monkeypatch.setattr(os, "link", late)
    with pytest.raises(UsageError, match="exists already"):
        write_whole(path, DATA)
    assert path.read_bytes() == b"theirs"
    assert names(path.parent) == ["run.h5"]


def test_without_links_a_file_is_renamed(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", fails(PermissionError(errno.EPERM, "no links")))
    write_whole(path, DATA)
    assert path.read_bytes() == DATA
    assert names(path.parent) == ["run.h5"]


def test_without_links_no_other_file_is_replaced(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def late(_: Path, b: Path) -> None:
        Path(b).symlink_to("nowhere")
        raise PermissionError(errno.EPERM, "no links")

    monkeypatch.setattr(os, "link", late)
    with pytest.raises(UsageError, match="exists already"):
        write_whole(path, DATA)
    assert os.readlink(path) == "nowhere"


# -- what stands in the way
@pytest.mark.parametrize("force", [False, True])
def test_a_folder_or_none_is_refused(force: bool, path: Path) -> None:
    with pytest.raises(UsageError, match="is a folder: name a file in it"):
        refuse_existing(path.parent, force)
    with pytest.raises(UsageError, match="away does not exist: make it"):
        refuse_existing(path.parent / "away" / "run.h5", force)
    refuse_existing(path, force)


def test_a_link_that_leads_nowhere_is_in_the_way(path: Path) -> None:
    path.symlink_to("nowhere")
    with pytest.raises(UsageError, match="exists already"):
        refuse_existing(path, False)
    refuse_existing(path, True)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="Windows has no such files")
def test_what_is_no_ordinary_file_is_not_replaced(path: Path) -> None:
    os.mkfifo(path)
    with pytest.raises(UsageError, match="is no ordinary file"):
        refuse_existing(path, True)
    with pytest.raises(UsageError, match="is no ordinary file"):
        check_writable(path, force=True)
    with pytest.raises(UsageError, match="exists already"):
        refuse_existing(path, False)


# -- a folder's names
def test_a_folder_is_closed_even_if_it_is_not_synced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[int] = []
    closed: list[int] = []
    actual_open, actual_close = os.open, os.close
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fails(OSError("odd")))
        patch.setattr(os, "open", lambda *a: opened.append(actual_open(*a)) or opened[-1])
        patch.setattr(os, "close", lambda one: closed.append(one) or actual_close(one))
        with pytest.raises(OSError, match="odd"):
            sync_folder(tmp_path)
    assert len(opened) == 1
    assert opened == closed


def test_windows_syncs_names_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    sync_folder(tmp_path / "away")
