"""A capture file that this process did not write is read by a child, which may crash or hang."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import child, store, store_child, store_pack
from motorid.capture.model import Capture
from motorid.errors import DataError
from motorid.limits import CAPTURE
from tests.exact_capture import FAULHABER, clean_capture


@pytest.fixture
def capture() -> Capture:
    return clean_capture(FAULHABER)


@pytest.fixture(autouse=True)
def written(monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """What this process has written: nothing yet."""
    nothing: set[str] = set()
    monkeypatch.setattr(store, "_written", nothing)
    return nothing


@pytest.fixture
def foreign(capture: Capture, tmp_path: Path) -> Path:
    """A capture file that another process wrote."""
    path = tmp_path / "foreign Ω.h5"
    path.write_bytes(store.to_bytes(capture))
    return path


@pytest.mark.slow
def test_what_a_child_reads_is_what_this_process_reads(
    foreign: Path, capture: Capture, tmp_path: Path, written: set[str]
) -> None:
    own = store.load(store.save(capture, tmp_path / "own.h5"))
    written.clear()
    other = store.load(foreign)
    assert own.sha256 == other.sha256 != ""
    mine, theirs = store_pack.pack(own), store_pack.pack(other)
    assert mine.keys() == theirs.keys()
    for name in mine.keys() - {"facts"}:
        np.testing.assert_array_equal(mine[name], theirs[name])
        assert mine[name].dtype == theirs[name].dtype
    assert store.to_bytes(own) == store.to_bytes(other)


def test_own_files_need_no_child_until_they_change(
    capture: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(*args: Any, **more: Any) -> Any:
        raise AssertionError("a child")

    monkeypatch.setattr(child, "arrays_from", none)
    path = store.save(capture, tmp_path / "own.h5")
    assert len(store.load(path)) == len(capture)
    path.write_bytes(path.read_bytes() + b"\0")
    with pytest.raises(AssertionError, match="a child"):
        store.load(path)


def replace_child(monkeypatch: pytest.MonkeyPatch, folder: Path, body: str) -> None:
    program = folder / "program.py"
    program.write_text(body)
    monkeypatch.setattr(store_child, "__file__", str(program))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "says"),
    [
        ("import os; os.abort()", "ended with code"),
        ("import sys; sys.exit(1)", "ended with code 1"),
        ("print('x')", "x"),
        ("raise ValueError('odd')", "ended with code 1"),
    ],
)
def test_a_child_that_dies_is_one_sentence(
    body: str, says: str, foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace_child(monkeypatch, tmp_path, body)
    with pytest.raises(DataError, match="not a readable capture file") as caught:
        store.load(foreign)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 4


@pytest.mark.slow
def test_a_child_that_hangs_is_stopped(
    foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace_child(monkeypatch, tmp_path, "import time; time.sleep(60)")
    monkeypatch.setattr(child, "PATIENCE_S", 0.3)
    with pytest.raises(DataError, match=r"more than 0\.3 s and was stopped"):
        store.load(foreign)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's memory")
def test_a_child_that_works_without_end_is_stopped(
    foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After so much of the processor's time, however long that takes."""
    body = "from motorid.capture.child import serve\nserve(lambda s, t: any(iter(int, 1)), [])"
    replace_child(monkeypatch, tmp_path, body)
    monkeypatch.setattr(store, "CAPTURE", replace(CAPTURE, cpu_s=0))
    with pytest.raises(DataError, match="s of the processor and was stopped: the file is damaged"):
        store.load(foreign)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's memory")
def test_a_child_that_eats_memory_is_refused(
    foreign: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = "from motorid.capture.child import serve\nserve(lambda s, t: bytearray(6 << 30), [])"
    replace_child(monkeypatch, tmp_path, body)
    with pytest.raises(DataError, match="MemoryError"):
        store.load(foreign)


NURSERY = """
import os, time
import numpy as np
from motorid.capture.child import serve

def main(source, target):
    if "dies" in source:
        os.abort()
    if "hangs" in source:
        time.sleep(60)
    print("not for the parent")
    np.savez(target, ids=np.array([os.getpid(), os.getppid()]))

serve(main, ["json"])
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows forks no process")
def test_one_warm_child_forks_one_for_each_file(tmp_path: Path) -> None:
    """So libraries are loaded once, and what kills or stops the reader of a file is its alone."""
    program = tmp_path / "nursery.py"
    program.write_text(NURSERY)

    def ids(name: str, time_s: float = 60.0) -> list[int]:
        path = tmp_path / name
        path.touch()
        found = child.arrays_from(str(program), path, CAPTURE, patience_s=time_s)
        return [int(one) for one in found["ids"]]

    first = ids("a.h5")
    with pytest.raises(child.ChildFailedError, match="code -6"):
        ids("dies.h5")
    second = ids("b.h5")
    assert first[0] != second[0]
    assert first[1] == second[1] != os.getpid()
    with pytest.raises(DataError, match="was stopped"):
        ids("hangs.h5", time_s=0.5)
    assert ids("c.h5")[1] != first[1]  # the one that waited for it went with it


FRAIL = """
import os, sys
import numpy as np
from motorid.capture.child import serve

def main(source, target):
    if len(sys.argv) == 1:
        os.abort()  # as a library that bears no fork does
    np.savez(target, ids=np.array([1]))

serve(main, [])
"""


@pytest.mark.slow
def test_a_fork_that_dies_condemns_no_file(tmp_path: Path) -> None:
    program = tmp_path / "frail.py"
    program.write_text(FRAIL)
    (tmp_path / "a.h5").touch()
    assert child.arrays_from(str(program), tmp_path / "a.h5", CAPTURE)["ids"][0] == 1
