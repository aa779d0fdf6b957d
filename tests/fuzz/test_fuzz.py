"""The parsers' promises on every input kept, and on what a fuzzer finds in a few seconds.

FUZZ_SECONDS is how long each fuzzer runs; ``make fuzz`` runs each for a minute or as long as asked.
"""

from __future__ import annotations

import importlib
import os
import random
import re
import subprocess
import sys
from pathlib import Path

import pytest

from motorid.acquire.board import Board
from motorid.acquire.timeline import Timeline
from tests.fuzz import board
from tests.fuzz.targets import FILES, PARSERS

SECONDS = int(os.environ.get("FUZZ_SECONDS", "2"))
LEAST_RUNS = {
    "wire": 50,
    "rig": 30,
    "csv": 6,
    "look": 3,
    "journal": 6,
    "hdf5": 1,
    "mat": 1,
}  # it tried some, however busy the computer is
SHORTER = ("journal", "look", "hdf5", "mat")  # a third of the time is enough for these


@pytest.mark.slow
@pytest.mark.parametrize("target", PARSERS)
def test_what_was_kept_holds(target: str) -> None:
    checks = importlib.import_module(PARSERS[target].checks)
    inputs = list(checks.seeds())
    assert len(inputs) >= 10
    for data in inputs:
        checks.check(data)


@pytest.mark.slow
@pytest.mark.parametrize("target", PARSERS)
def test_changed_seeds_hold(target: str) -> None:
    """A little of what a fuzzer does, where none is installed."""
    checks = importlib.import_module(PARSERS[target].checks)
    rng, inputs = random.Random(1), list(checks.seeds())
    for _ in range(100):
        data = bytearray(rng.choice(inputs))
        for _ in range(rng.randrange(1, 4)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        checks.check(bytes(data))


def fuzz(target: str, seconds: int, folder: Path, root: Path) -> int:
    """How many inputs a fuzzer tried. Fails with what it found."""
    command = [sys.executable, "-m", "tests.fuzz.run", target, "--seconds", str(seconds)]
    done = subprocess.run(
        [*command, "--found", str(folder)], capture_output=True, text=True, cwd=root
    )
    assert done.returncode == 0, done.stderr[-3000:]
    runs = re.search(r"(?:Done|executed_units:) (\d+)", done.stderr)
    assert runs, done.stderr[-3000:]
    return int(runs[1])


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("target", PARSERS)
def test_a_fuzzer_finds_nothing(target: str, repo_root: Path, tmp_path: Path) -> None:
    pytest.importorskip("atheris", reason="no atheris: the fuzzer is not installed")
    seconds = SECONDS // 3 + 1 if target in SHORTER else SECONDS
    assert fuzz(target, seconds, tmp_path, repo_root) > LEAST_RUNS[target]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux limits a process's memory")
@pytest.mark.parametrize("target", FILES)
def test_changed_files_cost_one_sentence(target: str, repo_root: Path, tmp_path: Path) -> None:
    assert fuzz(target, SECONDS // 3 + 1, tmp_path, repo_root) > LEAST_RUNS[target]


def outcomes(first: int, cases: int) -> set[str]:
    """What came of so many boards. Raises AssertionError where one breaks a promise."""
    seen = set()
    for seed in range(first, first + cases):
        with board.in_memory() as folder:
            seen.add(board.run_case(seed, folder))
    return seen


@pytest.mark.slow
@pytest.mark.parametrize("first", [1, pytest.param(101, marks=pytest.mark.study)])
def test_boards_that_lie_cost_no_sample(first: int) -> None:
    assert len(outcomes(first, 20)) >= 3  # some are kept, some not


def test_a_sample_that_is_nowhere_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    add = Timeline.add
    monkeypatch.setattr(Timeline, "add", lambda s, b: add(s, b) if b.sequence != 9 else None)
    with pytest.raises(AssertionError, match="is nowhere"):
        outcomes(1, 10)


def test_a_motor_that_nobody_stops_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    tell = Board.tell
    monkeypatch.setattr(
        Board, "tell", lambda s, name, **f: tell(s, name, **f) if name != "stop" else None
    )
    with pytest.raises(AssertionError, match="no stop was sent"):
        outcomes(1, 40)


def test_a_broken_promise_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """A decoder that loses a frame at a split, and a reader that lets a current be negative."""
    from motorid.wire import framing
    from tests.fuzz import rig_checks, wire_checks

    data = framing.encode(b"\1ab") + framing.encode(b"\2cd")
    wire_checks.check(data)
    monkeypatch.setattr(framing.Decoder, "_end", lambda self, found: self._held.clear())
    with pytest.raises((AssertionError, IndexError)):
        wire_checks.check(data)
    monkeypatch.setattr(rig_checks, "parse", lambda text, where: (_ for _ in ()).throw(OSError()))
    with pytest.raises(OSError):
        rig_checks.check(b"name = 1")
