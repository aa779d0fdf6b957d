"""--clamped, and the question in its place."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from motorid.capture import store
from motorid.cli import rotor
from motorid.cli.main import run
from motorid.program import Rotor

RIG = """
port = "sim://?speed=max&clamped=1"
[wiring]
counts_per_turn = 2048
supply_voltage_v = 7
[limits]
current_a = 3
speed_rad_s = 1000
supply_min_v = 4
supply_max_v = 9
[nameplate]
resistance_ohm = 2.6
[sampling]
rate_hz = 10000
[program]
energy_j = 1
[[program.steps]]
kind = "prbs"
amplitude_v = 5
duration_s = 0.02
"""


@pytest.fixture
def bench(tmp_path: Path) -> str:
    (tmp_path / "bench.toml").write_text(RIG, encoding="utf-8")
    return str(tmp_path / "bench.toml")


class Terminal(io.StringIO):
    """A standard input that a person types into."""

    def isatty(self) -> bool:
        return True


def capture(bench: str, *more: str) -> tuple[int, Path]:
    path = Path(bench).with_name("run.h5")
    return run(["capture", "--rig", bench, "-o", str(path), *more]), path


def test_without_a_word_on_the_rotor_nothing_is_captured(
    bench: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    code, path = capture(bench)
    assert (code, path.exists()) == (2, False)
    assert "nobody said that it is: clamp it and give --clamped" in capsys.readouterr().err


@pytest.mark.slow
def test_the_option_says_it(bench: str) -> None:
    code, path = capture(bench, "--clamped")
    assert code == 0
    program = store.load(path).program
    assert program is not None
    assert program.rotor is Rotor.CLAMPED


@pytest.mark.slow
@pytest.mark.parametrize(("word", "code"), [("y", 0), ("", 2), ("n", 2)])
def test_a_person_is_asked(
    bench: str, word: str, code: int, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setattr("sys.stdin", Terminal(f"{word}\n"))
    assert capture(bench)[0] == code
    said = capsys.readouterr()
    assert rotor.QUESTION in said.out
    assert ("the rotor is not clamped" in said.err) == (code == 2)


def test_it_is_not_said_of_a_motor_that_turns(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.h5"
    assert run(["capture", "--rig", "sim", "-o", str(path), "--clamped"]) == 2
    assert "this one turns it: leave --clamped out" in capsys.readouterr().err
