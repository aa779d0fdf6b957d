"""``motorid import FILE`` without maps: what it shows, asks, takes and refuses."""

from __future__ import annotations

import io
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from motorid.capture import store
from motorid.capture.model import NOTES
from motorid.cli import main
from tests.capture_import.corpus import people
from tests.capture_import.corpus.bench_log import RPM, columns, text


class Terminal(io.StringIO):
    """What a person types, and where they read."""

    encoding = "utf-8"

    def isatty(self) -> bool:
        return True


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTORID_CONFIG", str(tmp_path / "config.toml"))
    people.german(tmp_path / "log.csv")
    table = columns(time=1.0, voltage=1.0, current=1.0, speed=RPM)
    (tmp_path / "open.csv").write_text(text("time_s,u,i,speed\n", table), encoding="ascii")
    return tmp_path


def typed(monkeypatch: pytest.MonkeyPatch, line: list[str], answers: str) -> tuple[int, str]:
    """Exit code and what was shown, where a person answers at a terminal."""
    out = Terminal()
    monkeypatch.setattr("sys.stdin", Terminal(answers))
    monkeypatch.setattr("sys.stdout", out)
    code = main.run(line)
    return code, out.getvalue()


@pytest.mark.slow
def test_without_a_terminal_it_proposes_and_imports_nothing(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["import", "log.csv"]) == 2
    said = capsys.readouterr()
    assert "--yes" in said.err
    assert not list(here.glob("*.h5"))
    line = said.out[said.out.index("motorid import") :].replace("\\\n", " ")
    assert main.run(shlex.split(line)[1:]) == 0  # the command it proposes is whole
    assert len(store.load(here / "log.h5")) == 600


@pytest.mark.slow
def test_yes_takes_a_proposal_and_the_capture_says_so(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["import", "log.csv", "--yes", "--serial", "SN 1"]) == 0
    assert "--serial 'SN 1'" in capsys.readouterr().out
    capture = store.load(here / "log.h5")
    assert "columns and units were proposed, and taken by --yes" in capture.provenance[NOTES]
    assert capture.provenance["serial"] == "SN 1"


@pytest.mark.slow
def test_yes_never_takes_what_is_open(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main.run(["import", "open.csv", "--yes"]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert not list(here.glob("*.h5"))
    (option, *_) = re.findall(r"--map (\S+)", error)
    assert option.startswith("speed=speed:")
    assert main.run(["import", "open.csv", "--yes", "--look", "--map", "speed=speed:rpm"]) == 0
    speed = store.load(here / "open.h5").channels["speed"]
    np.testing.assert_allclose(speed.values, columns(speed=1.0)[:, 0], atol=1e-4)


@pytest.mark.slow
def test_a_person_answers_and_confirms(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, shown = typed(monkeypatch, ["import", "open.csv"], "9\n1\ny\n")  # 9 is no answer
    assert code == 0
    assert "Unit of speed" in shown
    chosen = re.search(r"--map speed=speed:(\S+)", shown)
    assert chosen is not None
    assert f"1  {chosen[1]}" in shown
    assert (here / "open.h5").exists()


@pytest.mark.slow
def test_a_no_imports_nothing(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for answers in ("n\n", "\n", ""):
        code, _ = typed(monkeypatch, ["import", "log.csv"], answers)
        assert code in (2, 130)
    assert not list(here.glob("*.h5"))


@pytest.mark.slow
def test_a_number_completes_a_proposal(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    people.row_numbers(here / "rows.csv")
    answers = "2\nsoon\n-1\n0.002\ny\n"
    code, shown = typed(monkeypatch, ["import", "rows.csv", "-o", "rows.h5"], answers)
    assert code == 0
    assert "no number" in shown
    assert store.load(here / "rows.h5").time_s[1] == pytest.approx(0.002)


def test_maps_alone_are_followed_as_ever(here: Path) -> None:
    line = ["import", "open.csv", "--map", "time=time_s:s", "--map", "current=i:A", "-o", "n.h5"]
    assert main.run(line) == 0
    assert set(store.load(here / "n.h5").channels) == {"current"}


def test_a_terminal_without_braille_gets_its_plots(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Terminal, "encoding", "latin-1")
    _, shown = typed(monkeypatch, ["import", "log.csv"], "n\n")
    assert shown.encode("latin-1")
    assert "***" in shown


@pytest.mark.parametrize(
    ("maps", "said"),
    [
        (("foo=i:A",), "'foo' is not a quantity"),
        (("current=i:A", "current=v:A"), "current is mapped twice"),
    ],
)
def test_a_look_refuses_maps_as_an_import_does(
    here: Path, maps: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    options = [word for one in maps for word in ("--map", one)]
    files = [path for path in here.iterdir() if path.suffix == ".csv"]
    for look in ((), ("--look",)):
        assert main.run(["import", str(files[0]), *look, *options, "-o", "x.h5"]) == 2
        assert said in capsys.readouterr().err
