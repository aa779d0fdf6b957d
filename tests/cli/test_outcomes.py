"""What becomes of a command never depends on whether it could be printed."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pytest

from motorid import errors
from motorid.cli import streams as sink
from motorid.quality.limits import Limit
from motorid.quality.verdict import Measurement, Outcome, Reading, Verdict
from motorid.workflow import check as workflow
from tests.cli.streams import STATES, all_commands, command_of, run_main

PAIRS = tuple(itertools.product(STATES, STATES))
SOME_PAIRS = (*((state, state) for state in STATES), ("full", "open"), ("gone", "open"))


def raising(error: BaseException) -> Callable[..., Any]:
    def fail() -> None:
        click.echo("half of an answer")
        raise error

    return fail


def answering(code: int | None) -> Callable[..., Any]:
    def answer() -> int | None:
        click.echo("an answer")
        click.echo("a remark", err=True)
        return code

    return answer


OUTCOMES = {
    "an answer on stdout": (answering(None), 0),
    "PASS or a file": (answering(0), 0),
    "FAIL": (answering(1), 1),
    "INVALID": (answering(4), 4),
    "usage": (raising(errors.UsageError("no parameter Q")), 2),
    "usage of click's": (raising(click.UsageError("no such option")), 2),
    "rig": (raising(errors.RigError("the encoder is reversed")), 3),
    "link": (raising(errors.LinkError("nobody answers")), 3),
    "data": (raising(errors.DataError("the capture is empty")), 4),
    "a named file": (raising(PermissionError(13, "Permission denied", "x")), 4),
    "a disk": (raising(OSError(28, "No space left on device")), 4),
    "a connection": (raising(BrokenPipeError(32, "Broken pipe")), 4),
    "memory": (raising(MemoryError()), 4),
    "internal": (raising(ZeroDivisionError("by zero")), 70),
    "interrupted": (raising(KeyboardInterrupt()), 130),
}


@pytest.fixture(autouse=True)
def _tracebacks_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("words", all_commands(), ids=" ".join)
def test_every_command_by_every_outcome_and_stream(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The text of a traceback costs more than all else here, and has tests of its own."""
    monkeypatch.setattr("traceback.print_exception", lambda error, file: None)
    command = command_of(words)
    monkeypatch.setattr(command, "params", [])
    for name, (callback, code) in OUTCOMES.items():
        monkeypatch.setattr(command, "callback", callback)
        for out, err in PAIRS if words == ("rigs",) else SOME_PAIRS:
            is_lost = name == "an answer on stdout" and out in ("closed", "full")
            found, _, said = run_main(list(words), tmp_path, out, err)
            assert found == (errors.EXIT_DATA if is_lost else code), (name, out, err)
            assert "Traceback" not in said
            if is_lost and err == "open":
                assert "standard output cannot be written" in said
            if out == "gone" and err == "open" and code == 0:
                assert said == "a remark\n"  # whoever left had what he wanted


@pytest.mark.slow
@pytest.mark.parametrize("words", all_commands(), ids=" ".join)
def test_every_command_refuses_what_it_does_not_know(
    words: tuple[str, ...], tmp_path: Path
) -> None:
    for out, err in SOME_PAIRS:
        code, said, _ = run_main([*words, "--no-such-option"], tmp_path, out, err)
        assert (code, said) == (2, "")


@pytest.mark.parametrize("words", [(), *all_commands()], ids=" ".join)
def test_help_is_an_answer(words: tuple[str, ...], tmp_path: Path) -> None:
    codes = [run_main([*words, "--help"], tmp_path, out, "open")[0] for out in STATES]
    assert codes == [0, 4, 4, 0]


def verdict(outcome: Outcome) -> Verdict:
    limit = Limit("x", "1", 0, 1)
    measured = Measurement("x", "x", limit, Reading("1", 0.5, 0.1), outcome)
    return Verdict("p", "S1", (measured,))


@pytest.mark.parametrize("as_json", [[], ["--json"]], ids=["screen", "json"])
@pytest.mark.parametrize(("outcome", "code"), [("PASS", 0), ("FAIL", 1), ("INVALID", 4)])
def test_a_verdict_stands(
    outcome: str, code: int, as_json: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = verdict(Outcome[outcome])
    done = workflow.Inspection(found, None, found.exit_code)
    monkeypatch.setattr(workflow, "judge_stored", lambda *_, **__: done)
    (tmp_path / "x.h5").touch()
    line = ["check", "--product", "sim-disc", "--capture", str(tmp_path / "x.h5"), *as_json]
    for out, err in PAIRS:
        got, said, remark = run_main(line, tmp_path, out, err)
        assert got == code, (out, err)
        assert out != "open" or outcome in said
        if out == "full" and err == "open" and code == 1:
            assert "FAIL" in remark


@pytest.mark.parametrize(("error", "code"), [(MemoryError(), 70), (KeyboardInterrupt(), 130)])
def test_a_report_that_fails_is_no_fail_verdict(
    error: BaseException, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: BaseException) -> int:
        raise error

    monkeypatch.setattr("motorid.cli.main.report", broken)
    assert run_main(["nosuch"], tmp_path)[0] == code


def test_a_question_that_nobody_sees_is_not_asked(tmp_path: Path) -> None:
    """An answer read from a script must not set a motor going that nobody was warned of."""
    rig = tmp_path / "rig.toml"
    assert run_main(["rigs", "--show", "sim"], tmp_path)[0] == 0
    rig.write_text((tmp_path / "out").read_text(encoding="utf-8"), encoding="utf-8")
    for out in ("closed", "full", "gone"):
        code, _, said = run_main(["calibrate", str(rig), "--speed", "max"], tmp_path, out)
        assert code == 4
        assert "seen by nobody" in said


def test_the_terminal_that_nobody_learns_of_is_closed(tmp_path: Path) -> None:
    for out in ("closed", "full", "gone"):
        code, _, said = run_main(["sim", "--pty"], tmp_path, out)
        assert code == (2 if sys.platform == "win32" else 4)
        assert said.count("\n") == 1


def test_an_outlet_waits_for_a_slow_reader() -> None:
    """A pipe that somebody made non-blocking refuses what it has no room for; nothing is lost."""
    read, write = os.pipe()
    os.set_blocking(write, False)
    sent = b"x" * 300_000
    reader = subprocess.Popen(
        [sys.executable, "-c", "import sys; print(len(sys.stdin.buffer.read()))"],
        stdin=read,
        stdout=subprocess.PIPE,
    )
    os.close(read)
    outlet = sink.Outlet(os.fdopen(write, "wb", buffering=0))
    left = memoryview(sent)
    while left:
        left = left[outlet.write(left) :]
    assert outlet.raw is not None
    outlet.raw.close()
    assert reader.communicate(timeout=60)[0].split() == [b"300000"]
    assert outlet.problem is None


SHELL = {
    "$NOW rigs >&-": 4,
    "$NOW rigs 2>&-": 0,
    "$NOW rigs <&- >&- 2>&-": 4,
    "$NOW nosuch >&- 2>&-": 2,
    "$NOW rigs | head -c0": 0,
    "$UNBUFFERED rigs | head -c0": 0,
}
DEVICE = {
    "$NOW rigs >/dev/full": 4,
    "$UNBUFFERED rigs >/dev/full": 4,
    "$NOW nosuch 2>/dev/full": 2,
    "$NOW --version >/dev/full 2>&1": 4,
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no such redirections on Windows")
def test_the_real_process() -> None:
    """With the interpreter's own start and end: its last flush must not turn a 0 into a 120."""
    cases = SHELL | (DEVICE if Path("/dev/full").exists() else {})
    lines = [f"{line}; echo ${{PIPESTATUS[0]}}" for line in cases]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    motorid = f"{sys.executable} -m motorid"
    environment |= {"NOW": motorid, "UNBUFFERED": f"env PYTHONUNBUFFERED=1 {motorid}"}
    done = subprocess.run(
        ["bash", "-c", "\n".join(lines)], env=environment, capture_output=True, text=True
    )
    codes = [int(line) for line in done.stdout.split() if line.isdigit()]
    assert dict(zip(cases, codes, strict=True)) == cases
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
