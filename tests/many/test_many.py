"""Many captures: the same answers on one process and on several, resumed, and none fatal."""

from __future__ import annotations

import csv
import io
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.quality.history import open_history
from motorid.workflow import many
from motorid.workflow.many import Fitted, captures_in, fit_to_files, table

fit_many = partial(many.fit_many, model="six")  # the search for a better one has its own tests


@pytest.fixture(scope="module")
def captures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three short runs of simulated motors, one damaged file and one that is no capture."""
    folder = tmp_path_factory.mktemp("captures")
    for seed in (1, 2, 3):
        port = f"sim://?seed={seed}&speed=max"
        words = ["capture", "--rig", "sim", "--port", port, "--serial", f"SN-{seed}"]
        assert run([*words, "-o", str(folder / f"motor-{seed}.h5")]) == 0
    whole = (folder / "motor-1.h5").read_bytes()
    (folder / "sub").mkdir()
    (folder / "sub" / "cut.h5").write_bytes(whole[: len(whole) // 3])
    (folder / "sub" / "notes.h5").write_text("not a capture")
    return folder


@pytest.fixture(scope="module")
def alone(captures: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Fitted]:
    """All of them on one process."""
    folder = tmp_path_factory.mktemp("alone")
    return fit_many(captures_in([captures]), folder, jobs=1)


def timeless(fits: list[Fitted]) -> list[Fitted]:
    return [replace(fit, seconds=0.0) for fit in fits]


@pytest.mark.slow
def test_a_folder_is_its_captures_at_any_depth(captures: Path, tmp_path: Path) -> None:
    names = [path.name for path in captures_in([captures])]
    assert names == ["motor-1.h5", "motor-2.h5", "motor-3.h5", "cut.h5", "notes.h5"]
    assert len(captures_in([captures, captures / "motor-1.h5"])) == 5
    with pytest.raises(DataError, match="holds no capture"):
        captures_in([tmp_path])


@pytest.mark.slow
def test_failures_are_listed_and_not_fatal(alone: list[Fitted]) -> None:
    assert [bool(fit.failure) for fit in alone] == [False, False, False, True, True]
    assert [fit.serial for fit in alone[:3]] == ["SN-1", "SN-2", "SN-3"]
    assert all(fit.values["R"]["status"] == "estimated" for fit in alone[:3])
    assert all(str(fit.path) in fit.failure for fit in alone[3:])


@pytest.mark.slow
def test_several_processes_give_the_same_digits(
    captures: Path, alone: list[Fitted], tmp_path: Path
) -> None:
    together = fit_many(captures_in([captures]), tmp_path, jobs=2)
    assert timeless(together) == timeless(alone)


@pytest.mark.slow
def test_an_interrupted_run_goes_on(
    captures: Path, alone: list[Fitted], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second call fits only what the first did not finish, and answers for all."""
    paths = captures_in([captures])[:3]
    done: list[int] = []

    def stop(count: int, total: int) -> None:
        done.append(count)
        if count == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit_many(paths, tmp_path, progress=stop)
    fitted: list[Path] = []
    whole = many._fit
    monkeypatch.setattr(
        many, "_fit", lambda path, *rest: (fitted.append(path), whole(path, *rest))[1]
    )
    found = fit_many(paths, tmp_path)
    assert fitted == [paths[2]]
    assert timeless(found) == timeless(alone[:3])
    fit_many(paths[:1], tmp_path, fix={"R": 2.58})
    assert fitted[1:] == [paths[0]]  # other options are another fit


@pytest.mark.slow
def test_a_defect_costs_one_capture(
    captures: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import motorid.identify

    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr(motorid.identify, "fit", broken)
    (found,) = fit_many([captures / "motor-1.h5"], tmp_path)
    assert found.failure == "internal error, ZeroDivisionError: a defect"


def test_a_file_that_is_gone_is_a_failure_too(tmp_path: Path) -> None:
    (found,) = fit_many([tmp_path / "gone.h5"], tmp_path)
    assert "cannot be read" in found.failure
    with pytest.raises(DataError, match="none of 1 captures"):
        fit_to_files([tmp_path / "gone.h5"], tmp_path / "out")


def test_the_table_has_a_row_a_capture() -> None:
    values = {"R": {"value": 2.5, "total": 0.01, "status": "estimated", "unit": "ohm"}}
    fits = [
        Fitted("a.h5", "aa", "SN-1", values, ("W1",), "", 1.0),
        Fitted("b.h5", "", "", {}, (), "b.h5 is no capture", 0.0),
    ]
    rows = list(csv.DictReader(io.StringIO(table(fits), newline="")))
    assert (rows[0]["R"], rows[0]["u(R)"], rows[0]["R status"]) == ("2.5", "0.01", "estimated")
    assert (rows[1]["R"], rows[1]["failure"]) == ("", "b.h5 is no capture")


@pytest.mark.slow
def test_the_command(captures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A folder with --jobs; failures on stdout; the table is not replaced unasked."""
    words = ["fit", str(captures), "--model", "six", "--jobs", "2", "-o", str(tmp_path)]
    assert run(words) == 0
    said = capsys.readouterr().out
    assert "3 of 5 captures fitted" in said
    assert said.count("FAILED") == 2
    assert (tmp_path / "fits.csv").exists()
    assert run(words) == 2
    assert run([*words, "--force"]) == 0  # at once: every answer is kept
    assert run(["fit", str(captures), "-o", str(tmp_path), "--json"]) == 2
    assert run([*words, "--force", "--seed", "3"]) == 2  # of one fit
    shutil.rmtree(tmp_path / "runs")


@pytest.mark.slow
def test_the_command_on_a_query(captures: Path, tmp_path: Path) -> None:
    """The captures that a history knows, chosen by serial number."""
    from motorid.capture.store import load
    from motorid.quality.history.records import ResultRecord, capture_record

    with open_history(tmp_path / "line.db") as history:
        for seed in (1, 2, 3):
            capture = load(captures / f"motor-{seed}.h5")
            serial = str(capture.provenance["serial"])
            history.add(ResultRecord("check", serial, (), (capture_record(capture),)))
    words = ["--history", str(tmp_path / "line.db"), "--serial", "SN-[23]", "--jobs", "1"]
    assert run(["fit", *words, "-o", str(tmp_path / "none")]) == 4
    words[3] = "SN-2"
    assert run(["fit", *words, "-o", str(tmp_path / "out")]) == 0  # with the default model
    rows = (tmp_path / "out" / "fits.csv").read_text().splitlines()
    assert len(rows) == 2
    with pytest.raises(UsageError, match="exists already"):
        fit_to_files([captures / "motor-2.h5"], tmp_path / "out")
