"""Whatever goes wrong: one sentence on stderr, the documented code, and no traceback."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from textwrap import dedent
from typing import Any, NoReturn

import pytest

from motorid import errors
from motorid.cli import main
from motorid.workflow import fit as workflow


@pytest.fixture
def capture_file(tmp_path: Path) -> str:
    """A file that exists; the commands under test fail before or after reading it."""
    path = tmp_path / "run.h5"
    path.write_bytes(b"")
    return str(path)


def failing_with(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    def raise_it(*_: Any, **__: Any) -> NoReturn:
        raise error

    monkeypatch.setattr(workflow, "fit_files", raise_it)


def sentence(capsys: pytest.CaptureFixture[str]) -> str:
    """What stderr says: one line, no traceback."""
    text = capsys.readouterr().err
    assert text.startswith("motorid: ")
    assert text.count("\n") == 1
    assert "Traceback" not in text
    return text


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (errors.UsageError("no parameter Q"), 2),
        (errors.RigError("the encoder is reversed"), 3),
        (errors.LinkError("nobody answers"), 3),
        (errors.DataError("the capture\nis empty"), 4),
        (PermissionError(13, "Permission denied", "/root/x"), 4),
        (ZeroDivisionError("float division by zero"), 70),
        (EOFError("end"), 70),
        (KeyboardInterrupt(), 130),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else str(value),
)
def test_each_error_has_its_code_and_sentence(
    error: BaseException,
    code: int,
    capture_file: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    failing_with(monkeypatch, error)
    assert main.run(["fit", capture_file]) == code
    assert sentence(capsys)


def test_internal_error_leaves_its_traceback_in_a_file(
    capture_file: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    failing_with(monkeypatch, ZeroDivisionError("by zero"))
    main.run(["fit", capture_file])
    named = re.search(r"Where it happened is in (\S+)\.", sentence(capsys))
    assert named
    assert "ZeroDivisionError: by zero" in Path(named[1]).read_text(encoding="utf-8")


def test_traceback_on_request(
    capture_file: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MOTORID_TRACEBACK", "1")
    failing_with(monkeypatch, errors.DataError("no samples"))
    assert main.run(["fit", capture_file]) == 4
    assert "Traceback" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["fitt", "x.h5"], "did you mean 'fit'"),
        (["fit"], "Missing argument"),
        (["fit", "absent.h5"], "absent.h5"),
        (["fit", "--colour", "x.h5"], "--colour"),
        (["fit", "--fix", "K", "x.h5"], "'K' is not NAME=NUMBER"),
        (["fit", "--fix", "K=fast", "x.h5"], "K=fast"),
        (["capture", "--rig", "sim"], "--output"),
        (["capture", "--rig", "sim", "-o", "x.h5", "--repeat", "0"], "--repeat"),
        (["--nonsense"], "--nonsense"),
    ],
    ids=" ".join,
)
def test_usage_errors(
    line: list[str],
    said: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.run(line) == 2
    assert said in sentence(capsys)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("line", [[], ["--help"], ["-h"], ["--version"], ["fit", "--help"]])
def test_help_is_a_success(line: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(line) == 0
    captured = capsys.readouterr()
    assert captured.out
    assert not captured.err


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to a child alone")
def test_an_interruption_while_a_class_is_made_ends_with_its_own_code(tmp_path: Path) -> None:
    """CPython would end by SIGINT: subprocess then shows -2, and no shell script an exit code."""
    program = """
        import os, signal
        from motorid.cli import main
        pressed = "os.kill(os.getpid(), signal.SIGINT)\\nfor _ in range(9): pass"
        main._invoke = lambda args: exec(pressed)
        main.main()
    """
    (tmp_path / "bench.py").write_text(dedent(program), encoding="utf-8")
    command = [sys.executable, "-m", "bench"]
    child = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (child.returncode, child.stderr) == (130, "motorid: interrupted\n")


def test_readme_lists_every_exit_code(repo_root: Path) -> None:
    readme = (repo_root / "README.md").read_text(encoding="utf-8")
    for code, meaning in errors.MEANING_OF_EXIT.items():
        assert f"| {code} | {meaning} |" in readme
    assert set(errors.MEANING_OF_EXIT) == {0, 1, 2, 3, 4, 70, 130}
