"""The driver of the studies that take hours: what it writes, and that each command is one."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from bench import evidence
from bench.evidence import PARTS, ROOT, Part

SAYS = (sys.executable, "-c", f"print('from', {str(ROOT)!r}, '{{commit}}')")
FAILS = (sys.executable, "-c", "raise SystemExit(3)")


def header(path: Path) -> dict[str, str]:
    lines = path.read_text(encoding="utf-8").split("\n\n")[0].splitlines()
    return dict(line.split(": ", 1) for line in lines)


@pytest.mark.slow
def test_a_result_says_what_made_it(tmp_path: Path) -> None:
    assert evidence.run(Part("words", "that it speaks", (SAYS,), ()), False, tmp_path)
    found = header(tmp_path / "words.txt")
    assert found["commit"] == evidence.commit()
    assert (found["shows"], found["form"], found["exit codes"]) == ("that it speaks", "full", "0")
    assert set(found) >= {"date", "on", "took"}
    said = (tmp_path / "words.txt").read_text(encoding="utf-8")
    assert f"\nfrom . {evidence.commit()}\n" in said
    assert str(ROOT) not in said


@pytest.mark.slow
def test_a_command_that_fails_is_kept_and_said(tmp_path: Path) -> None:
    part = Part("words", "that it speaks", (), (FAILS, SAYS))
    assert not evidence.run(part, True, tmp_path)
    found = header(tmp_path / "words.txt")
    assert found["exit codes"] == "3 0"
    assert "proves nothing" in found["form"]


def test_only_the_end_of_much_is_kept() -> None:
    kept = evidence.page({"part": "x"}, "\n".join(map(str, range(1000))))
    assert "(800 lines before)" in kept
    assert kept.splitlines()[-1] == "999"


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_every_command_of_a_part_is_there(part: Part) -> None:
    for command in (*part.full, *part.short):
        first = command[1]
        there = find_spec(command[2]) if first == "-m" else (ROOT / first).is_file()
        assert there, command
    page = (ROOT / "docs" / "evidence.md").read_text(encoding="utf-8")
    assert f"| `{part.name}` | " in page
