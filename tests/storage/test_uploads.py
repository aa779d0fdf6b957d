"""Inspections go into an object store behind the cycle: none lost, none twice, no line held up."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from motorid.cli.main import run
from motorid.errors import DataError
from motorid.quality.history import open_history
from motorid.storage import object_store
from motorid.storage.place import Url
from motorid.workflow.behind import Behind
from motorid.workflow.uploads import MARK, Uploads
from tests.storage.stores import ENVIRONMENT, PATIENCE_S, Store, until

pytestmark = pytest.mark.slow


def inspection(folder: Path, name: str) -> Path:
    """A judged one, as far as an upload looks at it."""
    made = folder / name
    made.mkdir(parents=True)
    for file in ("warm-up.h5", "capture.h5", "verdict.json"):
        (made / file).write_text(f"{name} {file}")
    return made


def test_an_inspection_is_uploaded_once_and_marked(here: Store, tmp_path: Path) -> None:
    to = Url(here.bucket("marked")) / "line-1"
    one = inspection(tmp_path / "shift", "D1_20261125T060000")
    (tmp_path / "shift" / "D2_20261125T060100").mkdir()  # is being measured
    uploads = Uploads(to)
    assert uploads.take(one) == ""
    assert here.keys("marked") == {
        f"line-1/{one.name}/{file}" for file in ("warm-up.h5", "capture.h5", "verdict.json")
    }
    assert f"{to}/{one.name}/capture.h5" in (one / MARK).read_text()
    (one / MARK).unlink()  # killed between upload and mark
    assert uploads.catch_up(tmp_path / "shift") == "1 inspections were uploaded. "
    assert uploads.catch_up(tmp_path / "shift") == ""


def test_one_that_cannot_be_uploaded_holds_up_no_other(here: Store, tmp_path: Path) -> None:
    to = Url(here.bucket("mixed"))
    for name in ("D1_1", "D2_1", "D3_1"):
        inspection(tmp_path / "shift", name)
    here.put("mixed", "D2_1/capture.h5", b"of another station")
    said = Uploads(to).catch_up(tmp_path / "shift")
    assert "2 inspections were uploaded. 1 could not be" in said
    assert here.stored("mixed", "D2_1/capture.h5") == b"of another station"
    assert not (tmp_path / "shift" / "D2_1" / MARK).exists()


def test_a_store_that_comes_back_gets_what_waited_without_being_asked(tmp_path: Path) -> None:
    """While the line stands still, and with one sentence to the operator for the whole outage."""

    class Away:
        tried, back, caught = 0, False, threading.Event()

        def take(self, folder: Path) -> str:
            return "" if self.back else "D1 is not in the object store yet (away)"

        def catch_up(self, folder: Path) -> str:
            self.tried += 1
            if not self.back:
                raise DataError("away")
            self.caught.set()
            return "1 inspections were uploaded. "

    book, told = Away(), list[str]()
    worker = Behind(book, tmp_path, told.append, again_s=0.01)
    worker.start()
    until(lambda: book.tried > 3, "it tries again")
    book.back = True
    assert book.caught.wait(PATIENCE_S)
    assert worker.close(PATIENCE_S) == ""
    assert told == [
        "earlier inspections are not there yet (away)",
        "1 inspections were uploaded. ",
    ]


@pytest.mark.long
def test_a_killed_station_without_a_store_loses_nothing(
    here: Store, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The store is away for a shift that ends by SIGKILL; the next shift uploads both motors."""
    place = str(tmp_path / "line.db")
    words = ["station", "--product", "sim-disc", "--rig", "sim-line", "--speed", "max"]
    words += ["--no-listen", "-o", "s3://shift/line-1", "--history", place, "--station", "s1"]

    def begun(address: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-m", "motorid", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, **ENVIRONMENT, "AWS_ENDPOINT_URL": address},
        )

    def inspected(station: subprocess.Popen[str], serial: str) -> None:
        assert station.stdin is not None
        assert station.stdout is not None
        station.stdin.write(f"{serial}\n")
        station.stdin.flush()
        assert any(line.startswith("PASS") and serial in line for line in station.stdout)

    station = begun("http://127.0.0.1:9")
    inspected(station, "D000001")
    station.kill()
    station.communicate()
    here.bucket("shift")
    station = begun(here.address)
    inspected(station, "D000002")
    until(lambda: len(here.keys("shift")) == 4, "both are uploaded")
    with open_history(place) as history:
        until(lambda: history.count() == 2, "both are in the history")
    station.communicate(timeout=PATIENCE_S)
    keys = here.keys("shift")
    assert {key.rpartition("/")[2] for key in keys} == {"capture.h5", "verdict.json"}
    spool = tmp_path / "spool" / "s3" / "shift" / "line-1"
    for key in keys:
        kept = spool / key.removeprefix("line-1/")
        assert here.stored("shift", key) == kept.read_bytes()
    with open_history(place) as history:
        paths = {row.path.removeprefix("s3://shift/") for row in history.captures()}
    assert paths == {key for key in keys if key.endswith("/capture.h5")}
    assert run(["history", "rejudge", place, "--product", "sim-disc"]) == 0
    assert "2 judged, 0 changed, 0 failed" in capsys.readouterr().err


def test_a_check_is_uploaded_and_one_that_is_not_waits_for_the_next(
    here: Store,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    here.bucket("checks")
    words = ["check", "--product", "sim-disc", "--rig", "sim-line", "--speed", "max"]
    words += ["-o", "s3://checks/a", "--serial"]
    away = monkeypatch.context
    with away() as context:
        context.setattr(object_store, "put", _away)
        context.setattr(object_store, "exists", _away)
        assert run([*words, "D000001"]) == 0  # the verdict stands
    assert "it is uploaded by the next one" in capsys.readouterr().err
    assert here.keys("checks") == set()
    assert run([*words, "D000002"]) == 0
    assert "2 inspections were uploaded" in capsys.readouterr().err
    assert len(here.keys("checks")) == 4


def _away(*_: object, **__: object) -> str:
    raise DataError("the store is away")
