"""How a file is given to a child, what becomes of its answer, and what the child does of itself."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.capture import child
from motorid.capture.child import Bounds, ChildFailedError
from motorid.capture.warm_child import GoneError
from motorid.errors import DataError, UsageError
from motorid.limits import CAPTURE, MB

BOUNDS = Bounds(500, 7)
Answer = Callable[..., tuple[int, str]]


def answers(code: int, said: str, written: bool = True) -> Answer:
    def answer(_: str, __: Path, target: Path, *___: Any) -> tuple[int, str]:
        if written:
            np.savez(target, x=np.array([1, 2]), y=np.array([0.5]))
        return code, said

    return answer


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "a.h5"
    path.write_bytes(bytes(1000))
    return path


def arrays(source: Path, **how: Any) -> Any:
    return child.arrays_from("program.py", source, CAPTURE, **how)


# -- what an answer means
def test_what_a_child_wrote_is_read_by_name(source: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "_read_warm", answers(0, "not for the parent"))
    found = arrays(source)
    assert {name: one.tolist() for name, one in found.items()} == {"x": [1, 2], "y": [0.5]}


@pytest.mark.parametrize(
    ("code", "said", "written", "kind", "says"),
    [
        (-24, "x", True, DataError, r"a\.h5: reading it took more than 10 s of the processor"),
        (152, "x", True, DataError, r"a\.h5: reading it took more than 10 s of the processor"),
        (3, "it is odd", True, DataError, r"a\.h5: it is odd$"),
        (1, "ValueError: odd", True, ChildFailedError, "^ValueError: odd$"),
        (1, "", True, ChildFailedError, "^the reader ended with code 1$"),
        (-6, "", False, ChildFailedError, "^the reader ended with code -6$"),
        (0, "", False, ChildFailedError, "^the reader ended with code 0$"),
    ],
)
def test_an_end_without_arrays_is_one_sentence(
    code: int, said: str, written: bool, kind: type[DataError], says: str, source: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr(child, "_read_warm", answers(code, said, written))
    with pytest.raises(DataError, match=says) as caught:
        arrays(source)
    assert type(caught.value) is kind


def test_a_sentence_that_names_the_file_is_left(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(child, "_read_warm", answers(3, f"{source}: it is odd"))
    with pytest.raises(DataError) as caught:
        arrays(source)
    assert str(caught.value) == f"{source}: it is odd"


def test_a_child_that_does_not_answer_is_named_with_its_patience(
    source: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def wait(*_: Any) -> Any:
        raise TimeoutError

    monkeypatch.setattr(child, "_read_warm", wait)
    with pytest.raises(DataError, match=r"a\.h5: reading it took more than 2\.5 s and was stopped"):
        arrays(source, patience_s=2.5)
    with pytest.raises(DataError, match="took more than 600 s and"):
        arrays(source)
    monkeypatch.setattr(child, "PATIENCE_S", 4.0)
    with pytest.raises(DataError, match="took more than 4 s and"):
        arrays(source)
    with pytest.raises(DataError, match="took more than 0 s and"):
        arrays(source, patience_s=0.0)


def test_what_a_child_may_take_is_by_the_limits_and_the_file_s_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.h5"
    with path.open("wb") as file:
        file.truncate(9 * MB)
    seen: list[Any] = []

    def note(program: str, source: Path, target: Path, bounds: Bounds, patience_s: float) -> Any:
        seen.extend([program, source, bounds, patience_s])
        return answers(0, "")(program, source, target)

    monkeypatch.setattr(child, "_read_warm", note)
    child.arrays_from("p.py", path, replace(CAPTURE, memory=77, cpu_s=10), patience_s=5.0)
    assert seen == ["p.py", path, Bounds(77, 12), 5.0]  # a second for each 4 MiB
    child.arrays_from("p.py", path, replace(CAPTURE, memory=None, cpu_s=None))
    assert seen[6] == Bounds(0, 2)
    with pytest.raises(DataError):
        child.arrays_from("p.py", path, replace(CAPTURE, file=9 * MB - 1))


# -- with a fork, or without
class Warm:
    """Stands for a warm child, which answers what it is told."""

    made: list[Warm]
    answer: Any

    def __init__(self, program: str, environment: dict[str, str]) -> None:
        self.program, self.environment, self.owner = program, environment, os.getpid()
        self.asked: list[Any] = []
        self.made.append(self)

    def read(self, *order: Any) -> tuple[int, str]:
        self.asked.append(order)
        if isinstance(self.answer, Exception):
            raise self.answer
        found: tuple[int, str] = self.answer
        return found


@pytest.fixture
def warm(monkeypatch: pytest.MonkeyPatch) -> type[Warm]:
    """The kind of children that is started; those that are read alone answer 9."""
    kind: type[Warm] = type("Fresh", (Warm,), {"made": [], "answer": (0, "well")})
    monkeypatch.setattr(child, "WarmChild", kind)
    monkeypatch.setattr(child, "FORKS", True)
    monkeypatch.setattr(child, "_warm", {})
    monkeypatch.setattr(child, "_read_alone", lambda *order: (9, repr(order)))
    return kind


def read(program: str = "p.py") -> tuple[int, str]:
    return child._read_warm(program, Path("a.h5"), Path("out.npz"), BOUNDS, 5.0)


ALONE = 9, repr(("p.py", Path("a.h5"), Path("out.npz"), BOUNDS, 5.0))


def test_each_program_has_one_warm_child(warm: type[Warm]) -> None:
    assert [read(), read(), read("q.py")] == [(0, "well")] * 3
    assert [one.program for one in warm.made] == ["p.py", "q.py"]
    assert warm.made[0].asked == [("a.h5", "out.npz", [500, 7], 5.0)] * 2
    assert warm.made[0].environment == child._environment()


def test_a_child_of_the_process_before_a_fork_is_not_asked(warm: type[Warm]) -> None:
    read()
    warm.made[0].owner += 1
    read()
    read()
    assert [len(one.asked) for one in warm.made] == [1, 2]


@pytest.mark.parametrize(
    ("code", "again"),
    [(0, False), (1, False), (3, False), (-6, True), (-24, False), (152, False), (-1, True)],
)
def test_what_a_signal_ended_is_read_without_a_fork(
    code: int, again: bool, warm: type[Warm]
) -> None:
    warm.answer = code, "well"
    assert read() == (ALONE if again else (code, "well"))
    read()
    assert len(warm.made) == 1


def test_a_warm_child_that_is_gone_is_followed_by_another(warm: type[Warm]) -> None:
    warm.answer = GoneError("odd")
    assert read() == ALONE
    warm.answer = TimeoutError()
    with pytest.raises(TimeoutError):
        read()
    assert child._warm == {}
    warm.answer = 0, "well"
    assert read() == (0, "well")
    assert len(warm.made) == 3


def test_without_forks_each_file_has_a_child_of_its_own(
    warm: type[Warm], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(child, "FORKS", False)
    assert read() == ALONE
    assert warm.made == []


def program(folder: Path, text: str) -> str:
    path = folder / "program.py"
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_a_child_alone_gets_its_order_as_arguments(tmp_path: Path) -> None:
    text = (
        "import os, sys\nprint(sys.argv[1:], sys.flags.safe_path, 'Ω', repr(sys.stdin.read()))\n"
        "print(os.environ['OPENBLAS_NUM_THREADS'])\nprint('x', file=sys.stderr)\nsys.exit(5)\n"
    )
    code, said = child._read_alone(
        program(tmp_path, text), Path("a.h5"), Path("out.npz"), BOUNDS, 60.0
    )
    assert code == 5
    assert said == "['a.h5', 'out.npz', '500', '7'] True Ω ''\n1"


def test_a_child_finds_motorid_first_then_what_the_parent_finds(
    repo_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", "more")
    assert child._environment()["PYTHONPATH"] == f"{repo_root}{os.pathsep}more"
    for none in (lambda: monkeypatch.setenv("PYTHONPATH", ""),
                 lambda: monkeypatch.delenv("PYTHONPATH")):  # fmt: skip
        none()
        assert child._environment()["PYTHONPATH"] == str(repo_root)
    found = child._environment()
    assert (found["OPENBLAS_NUM_THREADS"], found["PYTHONIOENCODING"]) == ("1", "utf-8")
    assert found["PATH"] == os.environ["PATH"]


# -- in the child
def raises(error: Exception) -> Callable[[str, str], None]:
    def main(_: str, __: str) -> None:
        raise error

    return main


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (UsageError("it is odd"), 3, "it is odd"),
        (ValueError("odd\nand more"), 1, "ValueError: odd"),
        (KeyError(), 1, "KeyError:"),
        (ValueError("x" * 300), 1, "ValueError: " + "x" * 188),
    ],
)
def test_a_child_says_in_one_line_what_failed(
    error: Exception, code: int, said: str, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr(child, "_limit", lambda _: None)
    assert child._read_one(raises(error), "a", "b", [1, 2]) == code
    assert capsys.readouterr().out.strip() == said


def test_a_child_is_limited_before_it_reads(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[Any] = []
    monkeypatch.setattr(child, "_limit", done.append)
    assert child._read_one(lambda *order: done.append(order), "a", "b", [1, 2]) == 0
    assert done == [Bounds(memory=1, cpu_s=2), ("a", "b")]


@pytest.mark.parametrize("warm", [False, True])
def test_a_child_loads_its_libraries_and_reads_one_file_or_waits_for_many(
    warm: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    done: list[Any] = []
    monkeypatch.setattr(child, "import_module", done.append)
    monkeypatch.setattr(child, "_limit", done.append)
    monkeypatch.setattr(child, "serve_files", lambda one: done.append(one("s", "t", [3, 4])))
    monkeypatch.setattr(sys, "argv", ["p.py", *(() if warm else ("a", "b", "1", "2"))])
    order = ("s", "t") if warm else ("a", "b")
    bounds = Bounds(3, 4) if warm else Bounds(1, 2)
    if warm:
        child.serve(lambda *order: done.append(order), ["one", "two"])
        assert done.pop() == 0
    else:
        with pytest.raises(SystemExit) as ended:
            child.serve(lambda *order: done.append(order), ["one", "two"])
        assert ended.value.code == 0
    assert done == ["one", "two", bounds, order]
