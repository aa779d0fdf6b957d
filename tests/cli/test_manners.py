"""Manners of a terminal: short pages, whole words, names that fit, defaults that are recorded."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import click
import pytest

import motorid
from motorid.acquire import ports
from motorid.acquire.ports import PortInfo
from motorid.cli import main, progress, settings, streams
from motorid.cli.paged import Paged
from motorid.cli.progress import Working, still
from motorid.errors import LinkError, UsageError
from motorid.motor.tally import Tally
from motorid.workflow.record import bench, dated_folder
from tests.cli.streams import all_commands, command_of

PAGE = 40  # lines


@pytest.fixture(autouse=True)
def _no_defaults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(settings.PLACE, str(tmp_path / "config.toml"))


def help_of(words: tuple[str, ...], capsys: pytest.CaptureFixture[str], *more: str) -> str:
    assert main.run([*words, *(more or ("--help",))]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("words", [(), ("gauge",), ("history",), *all_commands()], ids=" ".join)
def test_help_fits_a_terminal(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = help_of(words, capsys).splitlines()
    assert len(lines) <= PAGE
    assert max(map(len, lines)) <= 80


def test_commands_are_listed_by_task_and_none_is_lost(capsys: pytest.CaptureFixture[str]) -> None:
    page = help_of((), capsys)
    for heading in main.TASKS:
        assert f"\n{heading}:\n" in page
    for name in main.COMMANDS:
        assert re.search(rf"^  {name} ", page, re.MULTILINE), name
    assert {name for names in main.TASKS.values() for name in names} <= set(main.COMMANDS)


@pytest.mark.parametrize(
    "words", [w for w in all_commands() if isinstance(command_of(w), Paged)], ids=" ".join
)
def test_a_short_page_leads_to_the_whole_one(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    command = command_of(words)
    assert isinstance(command, Paged)
    assert set(command.common) <= {param.name for param in command.params}
    short, whole = help_of(words, capsys), help_of(words, capsys, "--help-all")
    assert "--help-all" in short
    options = [one for one in command.params if isinstance(one, click.Option)]
    assert [one.opts for one in options if not any(name in whole for name in one.opts)] == []
    assert len(whole.splitlines()) > len(short.splitlines())


def test_long_sentences_end_between_words(monkeypatch: pytest.MonkeyPatch) -> None:
    said = "motorid: /a/very/long/path/of/a/file.h5: a sentence of many words that is too long"
    assert streams.folded(said) == said  # to a file
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "40")
    lines = streams.folded(said).splitlines()
    assert len(lines) > 1
    assert all(len(line) <= 40 for line in lines)
    assert " ".join(" ".join(lines).split()) == said


def test_a_page_is_folded_line_by_line(monkeypatch: pytest.MonkeyPatch) -> None:
    page = "short\n  R     resistance   2.58 ± 0.01 Ω   0.02 %\n  " + "─" * 60
    assert streams.paged(page) == page
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "30")
    lines = streams.paged(page).splitlines()
    assert max(map(len, lines)) <= 30
    assert " ".join(lines).split()[:-1] == page.split()[:-1]


@pytest.mark.parametrize("name", ["x.csv", "x.MAT", "x.json", "x.h5.journal", "x.xlsx"])
def test_a_capture_is_not_named_as_something_else(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["capture", "--rig", "sim", "-o", str(tmp_path / name)]) == 2
    said = capsys.readouterr().err
    assert "a capture is an HDF5 file" in said
    assert ".h5" in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["run.csv", "run.h5", "report.html", "estimate.JSON"])
def test_a_folder_is_not_named_as_a_file(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["run", "--rig", "sim", "-o", str(tmp_path / name)]) == 2
    said = capsys.readouterr().err
    assert f"-o {Path(name).stem}" in said
    assert list(tmp_path.iterdir()) == []


def test_a_dot_in_a_name_is_no_kind_of_file(tmp_path: Path) -> None:
    from motorid.capture.naming import refuse_file_name, refuse_other_format

    for name in ("M17.2", "run", "run.capture", "run.hdf5"):
        refuse_other_format(tmp_path / name)
        refuse_file_name(tmp_path / name)


def test_a_folder_without_a_name_is_new_and_says_when(tmp_path: Path) -> None:
    first = dated_folder(tmp_path, "M 17/a")
    assert re.fullmatch(r"M-17-a_\d{4}-\d\d-\d\d_\d{4}", first.name)
    assert dated_folder(tmp_path, "../..").name.startswith("run_")
    made = []
    for _ in range(3):
        made.append(dated_folder(tmp_path))
        made[-1].mkdir()
    assert len(set(made)) == 3


@pytest.mark.slow
def test_run_needs_no_folder_and_records_what_it_took_from_the_defaults(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main.run(["config", "rig", "sim"]) == 0
    assert main.run(["config", "note", "bench 3"]) == 0
    words = ["run", "--serial", "M17", "--speed", "max", "--note", "typed"]
    assert main.run(words) == 0
    (folder,) = (path for path in tmp_path.iterdir() if path.is_dir())
    assert folder.name.startswith("M17_")
    files = {path.name for path in folder.iterdir()}
    assert files == {"capture.h5", "estimate.json", "report.html"}
    found = motorid.load(folder / "capture.h5").provenance
    assert found["settings"] == {"rig": "sim"}  # the note was typed
    assert found["note"] == "typed"


@pytest.fixture
def plugged(monkeypatch: pytest.MonkeyPatch) -> list[PortInfo]:
    found = [PortInfo("/dev/ttyS0", "built in", "")]
    monkeypatch.setattr(ports, "list_ports", lambda: tuple(found))
    return found


def test_port_auto_is_the_only_board(plugged: list[PortInfo]) -> None:
    with pytest.raises(LinkError, match="no board is plugged in"):
        bench("sim", port="auto")
    plugged.append(PortInfo("/dev/ttyACM0", "Uno", "2341:0043"))
    assert bench("sim", port="auto").port == "/dev/ttyACM0"
    plugged.append(PortInfo("/dev/ttyUSB1", "a printer", "1a86:7523"))
    with pytest.raises(LinkError, match=r"name the board's among /dev/ttyACM0, /dev/ttyUSB1"):
        bench("sim", port="auto")


def test_defaults_are_set_shown_and_forgotten(capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["config", "port", "auto"]) == 0
    assert main.run(["config", "jobs", "2"]) == 0
    assert settings.defaults()["capture"] == {"port": "auto"}
    assert settings.defaults()["compare"] == {"jobs": 2}
    capsys.readouterr()
    assert main.run(["config"]) == 0
    assert "port = 'auto'" in capsys.readouterr().out
    assert main.run(["config", "--unset", "port"]) == 0
    assert settings.read() == {"jobs": 2}


@pytest.mark.parametrize("key", ["limits", "calibration.current", "gain", "voltage_gain"])
def test_limits_calibration_and_gains_are_refused(
    key: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["config", key, "5"]) == 2
    assert "belong" in capsys.readouterr().err
    assert not settings.place().exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[limits]\nvoltage_v = 30\n", "'limits' is no default"),
        ("prot = 'x'\n", "did you mean 'port'"),
        ("jobs = 'two'\n", "jobs is to be a whole number"),
        ("port = ''\n", "port is to be a text"),
        ("port = \n", "not valid TOML"),
    ],
)
def test_a_bad_file_of_defaults_is_one_sentence(
    text: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    settings.place().write_text(text, encoding="utf-8")
    assert main.run(["ports"]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert str(settings.place()) in error
    assert main.run(["--help"]) == 0


def test_no_default_reaches_an_option_that_it_is_not_for() -> None:
    for one in settings.SETTINGS.values():
        for name in one.commands:
            assert one.parameter in {param.name for param in command_of((name,)).params}, name
    with pytest.raises(UsageError):
        settings.check("rig", 5, "config")


class Terminal:
    """Standard error that says that it is a terminal."""

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.text += text
        return len(text)

    def flush(self) -> None:
        pass


def test_work_shows_how_much_was_done_and_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal: Any = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(Working, "AFTER_S", 0.0)
    drawn = progress.threading.Event()
    monkeypatch.setattr(Tally, "responses", 1234)
    monkeypatch.setattr(progress, "paint", lambda stream, text: (stream.write(text), drawn.set()))
    with Working("fitting"):
        assert drawn.wait(60)
    assert "fitting  1,234 evaluations" in terminal.text
    assert terminal.text.endswith("\r")
    assert terminal.text.split("\r")[-2].strip() == ""


def test_work_is_silent_without_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with Working("fitting") as working:
        assert working.thread is None
    assert capsys.readouterr().err == ""


def test_the_mark_wanders_to_and_fro() -> None:
    lines = [still("fitting", 0, 0.25 * step) for step in range(60)]
    assert {line.count("###") for line in lines} == {1}
    assert len({len(line.split("]")[0]) for line in lines}) == 1
    assert len(set(lines)) > 20


def test_evaluations_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    import numpy as np

    from motorid.motor.reading import Output
    from motorid.motor.response import Response

    monkeypatch.setattr(Tally, "responses", 0)
    response = Response(1e-3, np.ones(5), [Output(0)])
    response((1.0, 1e-3, 0.01, 1e-5, 1e-5, 1e-3))
    assert progress.responses() == 1


def test_json_is_no_page(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a program reads is never folded."""
    text = json.dumps({"a": "b" * 200})
    monkeypatch.setenv("COLUMNS", "30")
    assert streams.paged(text) == text
