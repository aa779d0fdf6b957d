"""Whatever a person, a file or a database holds: a documented code and a sentence, never a 70."""

from __future__ import annotations

import os
import random
import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import click
import hypothesis
import pytest
from hypothesis import strategies as st

from motorid.cli import main
from motorid.cli.options import INSTANT, Assignment
from motorid.cli.values import FINITE, JOBS, Between, Named, Whole
from motorid.errors import EXIT_INTERNAL, MEANING_OF_EXIT
from motorid.quality.history import open_history
from tests.cli.streams import all_commands, command_of
from tests.history.records import record

DIGITS = "9" * 400
VALUES = (
    "", " ", DIGITS, f"-{DIGITS}", "9" * 5000, "1e999", "nan", "-inf", "100000000000", "0", "-1",
    "=", "K=", "K=nan", f"K={DIGITS}", f"R={DIGITS}%", "x" * 300, "a\nb", "\x1b[2J", "\udcff",
    "\0", "\u202e", "0001-01-01", "9999-12-31", "127.0.0.1:99999", "://", "sim://?motor=\x1b",
    "sqlite:///x?timeout=a", "postgresql://[::1", "current=i:\x1b", f"current={DIGITS}",
    "current=" + "(" * 300 + "i:A",
)  # fmt: skip


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with open(os.devnull, encoding="utf-8") as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        yield tmp_path


def refused(line: list[str], capsys: pytest.CaptureFixture[str]) -> int:
    """The exit code; what is said is a sentence without control characters."""
    code = main.run(line)
    said = capsys.readouterr()
    assert code in MEANING_OF_EXIT, line
    assert code != EXIT_INTERNAL, said.err
    assert "Traceback" not in said.err
    assert not {"\x1b", "\u202e", "\0"} & set(said.out + said.err)
    return code


def lines(words: tuple[str, ...]) -> Iterator[list[str]]:
    """Each option and argument of a command with each value, all else being absent."""
    for param in command_of(words).params:
        for value in VALUES:
            if not isinstance(param, click.Option):
                yield [*words, value]
            elif not param.is_flag:
                yield [*words, f"{param.opts[-1]}={value}"]


@pytest.mark.slow
@pytest.mark.parametrize("words", all_commands(), ids=" ".join)
def test_no_value_is_an_internal_error(
    words: tuple[str, ...], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for line in lines(words):
        refused(line, capsys)


@pytest.mark.parametrize(
    "expression", [DIGITS, f"i*{DIGITS}", f"i-0x{DIGITS}", "i**9", "1e999", "i/0"]
)
def test_no_expression_is_an_internal_error(
    expression: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "t.csv").write_text("t,i\n0,1\n1,2\n2,3\n", encoding="utf-8")
    line = [
        "import",
        "t.csv",
        "--map",
        "time=t:s",
        "--map",
        f"current={expression}:A",
        "-o",
        "x.h5",
    ]
    assert refused(line, capsys) in (2, 4)
    assert not (here / "x.h5").exists()


def test_a_name_that_steers_a_terminal_is_shown(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for line in (["fit", "a\x1b[2Jb.h5"], ["rigs", "--show", "a\x1b[2Jb"]):
        assert main.run(line) in (2, 3)
        assert r"a\x1b[2Jb" in capsys.readouterr().err
    (here / "a\x1b[2Jb.h5").touch()
    assert main.run(["history", "add", "x.db", ".", "--product", "sim-disc"]) == 4
    assert r"a\x1b[2Jb.h5" in capsys.readouterr().out


def kinds(folder: Path) -> dict[str, Path]:
    """Files of every kind that is none of ours."""
    contents: dict[str, bytes] = {
        "empty": b"",
        "nul": bytes(1000),
        "noise": random.Random(1).randbytes(1000),
        "latin.csv": b"part,operator,R\nA,\xff,1\n",
        "cell.csv": b"t,i\n1," + b"9" * 140_000 + b"\n2,3\n",
        "quoted.csv": b't,"' + b"x" * 140_000 + b'"\n1,2\n2,3\n',
        "digits.csv": b"part,operator,R\nA,x," + DIGITS.encode() + b"\nB,x,nan\n",
        "ragged.csv": b"part,operator,R\nA,x,1,2\nB\n",
        "deep.toml": b"a = " + b"[" * 5000,
        "number.toml": b"name = " + b"9" * 5000,
        "types.toml": b"name = [1]\nport = 5\n[limits]\ncurrent_a = 1e999\n",
        "torn.h5": b"\x89HDF\r\n\x1a\n" + bytes(100),
        "torn.journal": b"motorid journal 1\nH",
    }
    for name, data in contents.items():
        (folder / name).write_bytes(data)
    (folder / "folder").mkdir()
    found = {name: folder / name for name in [*contents, "folder"]}
    if hasattr(os, "mkfifo"):
        os.mkfifo(folder / "pipe")
        found["pipe"] = folder / "pipe"
    endless = [Path("/dev/zero"), Path("/dev/full")]
    return found | {path.name: path for path in endless if path.exists()}


READERS = {
    "segment": ["segment", "FILE"],
    "fit": ["fit", "FILE", "--model", "six"],
    "import": ["import", "FILE", "--map", "current=i:A", "--map", "time=t:s", "-o", "new.h5"],
    "recover": ["recover", "FILE"],
    "check": ["check", "--product", "sim-disc", "--capture", "FILE"],
    "product": ["check", "--product", "FILE", "--capture", "FILE"],
    "rig": ["plan", "--rig", "FILE", "--explain"],
    "show": ["rigs", "--show", "FILE"],
    "crossed": ["gauge", "crossed", "FILE"],
    "nested": ["gauge", "nested", "FILE"],
    "attribute": ["gauge", "attribute", "FILE"],
    "stations": ["gauge", "stations", "FILE", "--quantity", "R"],
    "golden": ["gauge", "golden", "FILE", "--quantity", "R", "--reference", "1"],
    "trend": ["trend", "FILE", "--quantity", "R"],
    "list": ["history", "list", "FILE"],
    "export": ["history", "export", "FILE", "-o", "new.csv", "--force"],
    "hex": ["flash", "--dry-run", "--port", "x", "--board", "uno", "--hex", "FILE"],
    "answers": ["calibrate", "sim", "--answers", "FILE"],
}


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_no_file_is_an_internal_error(
    reader: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, path in kinds(here).items():
        line = [str(path) if word == "FILE" else word for word in READERS[reader]]
        code = refused(line, capsys)
        # to show is to read and no more
        assert code in (2, 3, 4) or (reader == "show" and path.is_file()), (line, name)


def damaged(good: Path, place: Path) -> Iterator[None]:
    """The database with each column in turn holding what it cannot, and torn in some ways."""
    with sqlite3.connect(good) as db:
        tables = [row[0] for row in db.execute("select name from sqlite_master where type='table'")]
        columns = [(t, row[1]) for t in tables for row in db.execute(f"pragma table_info({t})")]
    for table, column in columns:
        shutil.copy(good, place)
        with sqlite3.connect(place) as db:
            try:
                db.execute(f"update {table} set {column}=?", (b"\xff[",))
            except sqlite3.IntegrityError:
                continue
        yield
    data, rng = good.read_bytes(), random.Random(1)
    for changes in (1, 20, 200):
        torn = bytearray(data)
        for _ in range(changes):
            torn[rng.randrange(len(torn))] = rng.randrange(256)
        place.write_bytes(torn)
        yield
    place.write_bytes(data[: len(data) // 2])
    yield


@pytest.mark.slow
def test_no_history_is_an_internal_error(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = here / "good.db"
    with open_history(good) as history:
        history.add(record(1))
    with sqlite3.connect(good) as db:
        db.execute("pragma journal_mode=delete")
    codes = set()
    for _ in damaged(good, here / "bad.db"):
        for rest in (
            ["list", "bad.db"],
            ["trace", "bad.db", "x"],
            ["export", "bad.db", "-o", "new.csv", "--force"],
        ):
            codes.add(refused(["history", *rest], capsys))
        codes.add(refused(["trend", "bad.db", "--quantity", "R"], capsys))
    assert codes >= {0, 4}


@pytest.mark.slow
@hypothesis.given(st.text() | st.from_regex(r"[A-Z]=-?[0-9e.%_]{1,12}") | st.floats().map(str))
@hypothesis.settings(max_examples=100)
def test_option_parsers_give_a_finite_value_or_a_usage_error(text: str) -> None:
    kinds = (FINITE, JOBS, Between(0, 10), Whole(min=1), INSTANT, Assignment("K=1"), Named())
    for kind in kinds:
        try:
            found = kind.convert(text, None, None)
        except click.UsageError:
            continue
        numbers = found[1:] if isinstance(found, tuple) else (found,)
        for number in numbers:
            if isinstance(number, int | float):
                assert abs(number) < float("inf")
