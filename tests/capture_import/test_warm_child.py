"""A child that forks one for each file: its orders, its answers and its end."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motorid.capture import child, warm_child
from motorid.capture.warm_child import SAID, GoneError, WarmChild


class EndedError(Exception):
    """Stands for the end of a process."""


def be_child(
    folder: Path, read_one: Callable[..., int], monkeypatch: pytest.MonkeyPatch
) -> tuple[int, str]:
    """Exit code, and what is beside the target then."""
    target = folder / "out.npz"
    codes: list[int] = []

    def end(code: int) -> None:
        codes.append(code)
        raise EndedError

    with (folder / "stdout").open("w") as out, monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", out)
        patch.setattr(os, "_exit", end)
        with pytest.raises(EndedError):
            warm_child._be_child(read_one, "a.h5", str(target), [1, 2])
    return codes[0], Path(f"{target}{SAID}").read_text()


def test_what_the_child_of_a_file_says_is_kept_beside_the_target(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def says(source: str, target: str, bounds: list[int]) -> int:
        print(source, Path(target).name, bounds)
        return 5

    (tmp_path / f"out.npz{SAID}").write_text("something longer than what is said this time")
    assert be_child(tmp_path, says, monkeypatch) == (5, "a.h5 out.npz [1, 2]\n")


def test_a_child_of_a_file_that_fails_ends_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: Any) -> int:
        raise KeyboardInterrupt

    assert be_child(tmp_path, fails, monkeypatch) == (1, "")
    if sys.platform != "win32":
        assert (tmp_path / f"out.npz{SAID}").stat().st_mode & 0o777 == 0o600


class Pipe:
    """Stands for a standard stream: lines to read, and what was written with each flush."""

    def __init__(self, lines: list[bytes]) -> None:
        self.buffer = self
        self.lines, self.kept, self.sent = lines, b"", [b""][:0]

    def __iter__(self) -> Any:
        return iter(self.lines)

    def write(self, data: bytes) -> None:
        self.kept += data

    def flush(self) -> None:
        self.sent.append(self.kept)
        self.kept = b""


def order_of(source: str, target: str, *bounds: int) -> bytes:
    names = (os.fsencode(name).hex() for name in (source, target))
    return " ".join([*names, *map(str, bounds)]).encode() + b"\n"


ORDERS = [order_of("a b\n.h5", "out.npz", 1, 2), order_of("Ω", "t", 3, 4)]


def test_a_warm_child_answers_each_order_with_its_child_s_exit_code(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    out = Pipe([])
    statuses = {41: 3 << 8, 42: 6}  # ended with code 3, by signal 6
    children = iter(statuses)
    monkeypatch.setattr(sys, "stdin", Pipe(ORDERS))
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(os, "fork", lambda: next(children))
    monkeypatch.setattr(os, "waitpid", lambda pid, how: (pid, statuses[pid + how]))
    warm_child.serve_files(lambda *_: 99)
    assert (out.sent, out.kept) == ([b"3\n", b"-6\n"], b"")


def test_in_the_fork_the_order_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Any] = []

    def be(*order: Any) -> None:
        seen.extend(order)
        raise EndedError

    def read_one(*_: Any) -> int:
        return 0

    monkeypatch.setattr(sys, "stdin", Pipe(ORDERS))
    monkeypatch.setattr(os, "fork", lambda: 0)
    monkeypatch.setattr(warm_child, "_be_child", be)
    with pytest.raises(EndedError):
        warm_child.serve_files(read_one)
    assert seen == [read_one, "a b\n.h5", "out.npz", [1, 2]]


# -- the warm child, as its parent sees it
ECHO = """
import sys
for line in sys.stdin:
    source, target, *bounds = line.split()
    if source == b"hangs".hex():
        continue
    if source == b"goes".hex():
        break
    with open(bytes.fromhex(target).decode() + ".said", "w") as said:
        print(bytes.fromhex(source).decode(), bounds, "Ω", file=said)
    print(len(bounds) - 5, flush=True)
"""


@pytest.fixture
def echo(tmp_path: Path) -> Any:
    """A warm child whose program answers by the number of bounds."""
    if not warm_child.FORKS:
        pytest.skip("Windows forks no process")
    program = tmp_path / "program.py"
    program.write_text(ECHO, encoding="utf-8")
    found = WarmChild(str(program), child._environment())
    yield found
    found.owner = os.getpid()
    found.stop()


def test_an_order_and_its_answer(echo: WarmChild, tmp_path: Path) -> None:
    target = str(tmp_path / "out.npz")
    assert echo.read("a b\n.h5", target, [1, 2], 60.0) == (-3, "a b\n.h5 ['1', '2'] Ω")
    assert echo.read("b", target, [3, 4, 5, 6, 7, 8], 60.0)[0] == 1
    assert echo.owner == os.getpid()


@pytest.mark.parametrize(
    ("name", "patience_s", "error"), [("hangs", 0.01, TimeoutError), ("goes", 60.0, GoneError)]
)
def test_a_warm_child_that_gives_no_answer_is_ended(
    name: str, patience_s: float, error: type[Exception], echo: WarmChild, tmp_path: Path
) -> None:
    with pytest.raises(error):
        echo.read(name, str(tmp_path / "out.npz"), [1, 2], patience_s)
    assert echo._process.returncode is not None
    assert all(pipe.closed for pipe in echo._pipes())
    with pytest.raises(GoneError):  # it stays so
        echo.read("a", str(tmp_path / "out.npz"), [1, 2], 60.0)


def test_only_its_owner_ends_a_warm_child(echo: WarmChild, tmp_path: Path) -> None:
    echo.owner += 1  # as after a fork
    echo.stop()
    assert echo.read("a", str(tmp_path / "out.npz"), [1], 60.0)[0] == -4
    assert os.getpgid(echo._process.pid) == echo._process.pid
    echo.owner -= 1
    echo.stop()
    assert echo._process.returncode == -9
