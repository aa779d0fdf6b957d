"""The table of commands in the documents, line by line: each of its lines is run."""

from __future__ import annotations

import fnmatch
import re
import shutil
import sqlite3
import tomllib
from pathlib import Path
from typing import Any

import pytest

from motorid import json_text
from motorid.acquire.journal import journal_path
from motorid.cli import main
from motorid.errors import MEANING_OF_EXIT
from motorid.quality.history import open_history
from motorid.rig_file import find
from tests.cli.streams import all_commands
from tests.export.estimates import document
from tests.flash.test_flash import hex_of
from tests.history.records import record
from tools import commands_page

FACTS: dict[str, dict[str, Any]] = tomllib.loads(commands_page.FACTS.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A capture, and beside it the journal that it was made from."""
    path = tmp_path_factory.mktemp("capture") / "run.h5"
    line = ["capture", "--rig", "sim", "--speed", "max", "-o", str(path), "--serial", "D000001"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("motorid.acquire.journal_writer.JournalWriter.discard", lambda self: None)
        assert main.run(line) == 0
    return path


@pytest.fixture(scope="module")
def made(capture: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files that the lines name."""
    folder = tmp_path_factory.mktemp("made")
    for name in ("run.h5", "other.h5"):
        (folder / name).write_bytes(capture.read_bytes())
    (folder / "cut.h5.journal").write_bytes(journal_path(capture).read_bytes())
    (folder / "uno.hex").write_text(hex_of(b"motorid-uno"), encoding="ascii")
    (folder / "bench.toml").write_text(
        find("sim").read_text(encoding="utf-8").replace("sim://?", "sim://?speed=max&"),
        encoding="utf-8",
    )
    (folder / "empty.h5").touch()
    (folder / "torn.h5.journal").write_bytes(b"motorid journal 1\nH")
    readings = "part,operator,R,R_ref\n" + "".join(
        f"{part},{operator},{2.5 + n / 20 + 0.002 * k + 0.001 * (operator == 'y')},{2.5 + n / 20}\n"
        for n, part in enumerate("ABCDE")
        for operator in "xy"
        for k in range(3)
    )
    (folder / "readings.csv").write_text(readings, encoding="utf-8")
    own = readings.replace("\nA,y", "\nF,y").replace("\nB,y", "\nG,y")
    (folder / "own.csv").write_text(own, encoding="utf-8")
    verdicts = "part,operator,rating,truth\n" + "".join(
        f"{part},{operator},{'FAIL' if part + operator in 'AxAyBx' else 'PASS'},"
        f"{'FAIL' if part == 'A' else 'PASS'}\n"
        for part in "ABCDE"
        for operator in "xy"
    )
    (folder / "verdicts.csv").write_text(verdicts, encoding="utf-8")
    rows = "".join(f"{k / 100},{1 + k % 3},{5 + k % 2},{100 + k}\n" for k in range(50))
    (folder / "log.csv").write_text("t,i,u,n\n" + rows, encoding="utf-8")
    for name, changed in (("estimate", {}), ("doubtful", {"K": {"status": "doubtful"}})):
        text = json_text.dumps(document(**changed))
        (folder / f"{name}.json").write_text(text, encoding="utf-8")
    with open_history(folder / "line.db") as history:
        history.add(record(1))
    with sqlite3.connect(folder / "line.db") as db:
        db.execute("pragma journal_mode=delete")
    return folder


@pytest.fixture
def here(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of them for one line alone."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def words_of(line: str) -> list[str]:
    return line.split(" ")


def files_in(folder: Path) -> dict[str, int]:
    """Each file below ``folder`` with when it was written, by its path from there."""
    return {
        path.relative_to(folder).as_posix(): path.stat().st_mtime_ns
        for path in folder.rglob("*")
        if path.is_file()
    }


def marked(name: str) -> Any:
    return pytest.param(name, marks=[pytest.mark.slow] if FACTS[name].get("slow") else [])


def test_every_command_has_its_line() -> None:
    assert set(FACTS) == {" ".join(words) for words in all_commands()}
    assert all(facts["again"] for facts in FACTS.values())


@pytest.mark.parametrize("name", [marked(name) for name in FACTS])
def test_a_command_leaves_what_the_table_says(name: str, here: Path, repo_root: Path) -> None:
    facts = FACTS[name]
    if "elsewhere" in facts:
        text = (repo_root / facts["elsewhere"]).read_text(encoding="utf-8")
        assert all(Path(pattern).name in text for pattern in facts["leaves"] if "*" not in pattern)
        return
    before = files_in(here)
    assert main.run(words_of(facts["works"])) == facts.get("code", 0)
    after = files_in(here)
    made = {path for path in after if path not in before}
    for pattern in facts["leaves"]:
        assert fnmatch.filter(made, pattern) or pattern.endswith("-*"), pattern
    left = {p for p in made if not any(fnmatch.fnmatch(p, known) for known in facts["leaves"])}
    assert left == set()


@pytest.mark.parametrize("name", FACTS)
def test_a_command_ends_as_the_table_says(
    name: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = FACTS[name]
    before = files_in(here).keys()
    for line, code in facts["ends"].items():
        assert line.startswith(name), line
        assert main.run(words_of(line)) == code, (line, capsys.readouterr().err)
        assert code in commands_page.codes(facts)
    new = files_in(here).keys() - before
    assert {path for path in new if not path.startswith("new.db")} == set()


@pytest.mark.parametrize("name", FACTS)
def test_a_verdict_is_shown_to_fail(name: str) -> None:
    facts = FACTS[name]
    shown = 1 in (*facts["ends"].values(), facts.get("code"))
    assert (shown or "elsewhere" in facts) == facts.get("verdict", False)
    assert set(commands_page.codes(facts)) <= set(MEANING_OF_EXIT)


def test_the_page_holds_the_table(repo_root: Path) -> None:
    page = (repo_root / "docs" / "commands.md").read_text(encoding="utf-8")
    for name in FACTS:
        assert re.search(rf"^\| `{re.escape(name)}` \|", page, re.MULTILINE), name
