"""The bundle of a conformance run: what it holds, what is skipped, and what damage is seen."""

from __future__ import annotations

import json
import os
import signal
import zipfile
from pathlib import Path
from typing import Any

import pytest

from motorid.capture import store
from motorid.cli.main import run
from motorid.errors import DataError, UsageError
from motorid.program import Decay, Program, Step, StepKind
from motorid.workflow.conformance import evidence, prove, suite
from motorid.workflow.conformance.bundle import MANIFEST, pack, unpack
from motorid.workflow.plan_file import with_program
from motorid.workflow.verify import DAMAGED, SOUND, verify
from tests.acquire.rigs import SHORT
from tests.calibrate.benches import rig_file

PARTS = ["board", "suite", *evidence.GUIDED, "runs", "coast", "fit"]


def proven(folder: Path, *words: str) -> tuple[int, Path]:
    """A conformance run of a simulated bench; its exit code and its bundle."""
    rig = rig_file(folder, more=with_program("", SHORT, "this test"))
    device = "sim://?motor=faulhaber-2338s006s&speed=max&seed=7&gain_uncertainty=0.02"
    target = folder / "board.zip"
    line = ["conformance", "--device", device, "--rig", str(rig), "-o", str(target), *words]
    return run(line), target


def manifest_of(path: Path) -> dict[str, Any]:
    with zipfile.ZipFile(path) as found:
        parsed: dict[str, Any] = json.loads(found.read(MANIFEST))
    return parsed


@pytest.mark.slow
def test_a_guided_run_becomes_a_bundle_that_verifies(tmp_path: Path) -> None:
    code, path = proven(tmp_path, "--simulated", "--no-suite", "--runs", "1", "--hold", "1")
    assert code == 0
    (found,) = verify([path])
    assert found.state == SOUND
    manifest = manifest_of(path)
    parts = {one["name"]: one for one in manifest["parts"]}
    assert list(parts) == PARTS
    assert [one["name"] for one in parts.values() if one["outcome"] != "done"] == ["suite"]
    assert "gain" in parts["current"]["says"]
    assert "zeta" in parts["disc"]["says"]
    assert manifest["finished"] is True
    (tmp_path / "out").mkdir()
    unpack(path, tmp_path / "out")
    assert store.load(tmp_path / "out" / "coast.h5").program is not None
    gained = (tmp_path / "out" / "rig.calibration.toml").read_text()
    assert "[current]" in gained
    assert "[disc]" in gained
    assert not (tmp_path / "bench.calibration.toml").exists()  # the bench's own stays as it was


@pytest.mark.slow
def test_the_suite_runs_against_a_port_and_its_cases_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("_runs", "_coast", "_fit"):  # another test has them
        monkeypatch.setattr(evidence.Evidence, name, lambda self: "")
    (tmp_path / "none.toml").write_text("")
    words = ("--answers", str(tmp_path / "none.toml"), "--select", "test_requests and repeated")
    code, path = proven(tmp_path, *words)
    parts = {one["name"]: one for one in manifest_of(path)["parts"]}
    assert code == 0, parts
    assert parts["suite"]["outcome"] == "done"
    assert parts["suite"]["says"].startswith("5 passed, 0 failed")
    assert parts["rest"]["outcome"] == "skipped"  # the file of answers has no table of it
    assert (tmp_path / "board" / suite.REPORT).is_file()


def test_a_device_where_nobody_answers_fails_and_leaves_a_bundle(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "board.zip"
    line = ["conformance", "--device", str(tmp_path / "no-port"), "--rig", str(rig_file(tmp_path))]
    assert run([*line, "-o", str(target), "--no-suite"]) == 3
    assert "board failed" in capsys.readouterr().err
    assert [one["outcome"] for one in manifest_of(target)["parts"]] == ["failed"]
    assert next(iter(verify([target]))).state == SOUND


@pytest.mark.slow
def test_ctrl_c_leaves_a_bundle_of_what_was_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "none.toml").write_text("")

    def pressed(self: evidence.Evidence) -> str:
        os.kill(os.getpid(), signal.SIGINT)
        return ""

    monkeypatch.setattr(evidence.Evidence, "_runs", pressed)
    code, path = proven(tmp_path, "--answers", str(tmp_path / "none.toml"), "--no-suite")
    assert code == 130
    manifest = manifest_of(path)
    assert manifest["finished"] is False
    assert manifest["parts"][0]["outcome"] == "done"


def test_a_part_that_fails_ends_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "none.toml").write_text("")

    def broken(self: evidence.Evidence) -> str:
        raise DataError("nothing came")

    for name in ("_runs", "_coast"):
        monkeypatch.setattr(evidence.Evidence, name, broken)
    code, path = proven(tmp_path, "--answers", str(tmp_path / "none.toml"), "--no-suite")
    assert code == 3
    outcomes = {one["name"]: one["outcome"] for one in manifest_of(path)["parts"]}
    assert outcomes["coast"] == outcomes["fit"] == "failed"


def test_names_that_are_taken_are_not_replaced(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"a bundle is a zip: name it board\.zip"):
        prove.make_way(tmp_path / "board", force=False)
    (tmp_path / "board").mkdir()
    (tmp_path / "board" / "mine.txt").write_text("mine")
    with pytest.raises(UsageError, match="exists already"):
        prove.make_way(tmp_path / "board.zip", force=False)
    assert (tmp_path / "board" / "mine.txt").exists()


# ---------------------------------------------------------------- bundles alone


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A bundle of two small files."""
    folder = tmp_path / "b"
    (folder / "disc").mkdir(parents=True)
    (folder / "README.txt").write_text("hello")
    (folder / "disc" / "notes.json").write_text("{}")
    return pack(folder, tmp_path / "b.zip", {"parts": []})


def rewritten(path: Path, change: dict[str, bytes | None]) -> Path:
    """The zip with members replaced, added, or (None) taken out."""
    with zipfile.ZipFile(path) as old:
        members = {name: old.read(name) for name in old.namelist()}
    members |= {name: data for name, data in change.items() if data is not None}
    with zipfile.ZipFile(path, "w") as new:
        for name, data in members.items():
            if change.get(name, b"") is not None:
                new.writestr(name, data)
    return path


@pytest.mark.parametrize(
    ("change", "where"),
    [
        ({"README.txt": b"other"}, "README.txt in it is not what the manifest says"),
        ({"more.txt": b"x"}, "'more.txt' is in the zip"),
        ({"README.txt": None}, "'README.txt' is in the zip"),
        ({"../evil.txt": b"x"}, "'../evil.txt' is in the zip"),
        ({MANIFEST: b"{}"}, "is no bundle of a conformance run"),
        ({MANIFEST: b"[]"}, "damaged"),
    ],
)
def test_damage_is_named(small: Path, change: dict[str, bytes | None], where: str) -> None:
    (found,) = verify([rewritten(small, change)])
    assert found.state == DAMAGED
    assert where in found.where


@pytest.mark.slow
def test_any_byte_that_is_changed_is_seen_or_changes_nothing(small: Path, tmp_path: Path) -> None:
    whole = small.read_bytes()
    for place in range(0, len(whole), 7):
        small.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        (found,) = verify([small])
        if found.state == SOUND:  # a field of the zip that names no content, such as a date
            out = tmp_path / f"out{place}"
            out.mkdir()
            unpack(small, out)
            assert (out / "README.txt").read_text() == "hello"


@pytest.mark.parametrize("length", [0, 4, 100])
def test_a_bundle_that_was_cut_is_damaged(small: Path, length: int) -> None:
    small.write_bytes(small.read_bytes()[:length])
    assert next(iter(verify([small]))).state == DAMAGED


def test_a_name_that_leaves_the_folder_is_refused_though_the_manifest_lists_it(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "b"
    folder.mkdir()
    (folder / "..x").write_text("x")
    (found,) = verify([pack(folder, tmp_path / "b.zip", {"parts": []})])
    assert found.state == DAMAGED


@pytest.mark.slow
def test_a_damaged_capture_in_a_sound_zip_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "b"
    folder.mkdir()
    (folder / "run-1.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))
    (found,) = verify([pack(folder, tmp_path / "b.zip", {"parts": []})])
    assert found.state == DAMAGED
    assert found.where.startswith("run-1.h5 in it")


def test_the_same_files_make_the_same_bytes(small: Path, tmp_path: Path) -> None:
    again = pack(tmp_path / "b", tmp_path / "again.zip", {"parts": []})
    assert again.read_bytes() == small.read_bytes()


def test_somebody_elses_zip_is_not_taken_for_one(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "else.xlsx", "w") as other:
        other.writestr("a.txt", "x")
    assert list(verify([tmp_path])) == []


# ---------------------------------------------------------------- suite and coast


def test_a_report_names_what_failed(tmp_path: Path) -> None:
    report = tmp_path / "suite.xml"
    report.write_text(
        "<testsuites><testsuite><testcase name='a'/><testcase name='b'><failure/></testcase>"
        "<testcase name='c'><skipped/></testcase><testcase name='d'><error/></testcase>"
        "</testsuite></testsuites>"
    )
    found = suite.read_report(report)
    assert found == suite.Outcome(1, ("b", "d"), 1)
    assert found.sentence() == "1 passed, 2 failed, 1 skipped: b, d"
    for text in ("", "<testsuites/>", "<testcase><skipped/></testcase>"):
        report.write_text(text)
        with pytest.raises(DataError):
            suite.read_report(report)


def test_without_a_working_copy_the_suite_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    assert suite.why_not() == ""
    monkeypatch.setattr(suite, "ROOT", Path("/nowhere"))
    assert "not in an installed package" in suite.why_not()


def test_a_coast_takes_the_fastest_drive_and_the_longest_coast() -> None:
    decay = Decay.SYNCHRONOUS_SLOW
    drives = [Step(StepKind.DRIVE_VOLTS, 0.5, volts, decay) for volts in (3.0, -6.0)]
    coasts = [Step(StepKind.COAST, seconds) for seconds in (0.2, 0.9)]
    found = evidence.coast_program(Program((coasts[0], drives[0], drives[1], coasts[1])))
    assert found is not None
    assert [step.level for step in found.steps] == [0.0, -6.0, 0.0]
    assert found.steps[-1].duration_s == 0.9
    assert evidence.coast_program(Program((coasts[0],))) is None
    assert evidence.coast_program(Program((drives[0],))) is None
