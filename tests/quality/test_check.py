"""motorid check: exit codes, files, and what goes wrong."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from motorid.cli.main import run
from motorid.estimate.model.capture_model import MotorRecord
from motorid.quality.product import Product
from motorid.rig import Rig
from motorid.sim import truth
from motorid.workflow.check import Line, resume

LINE = "sim://?motor=faulhaber-2338s006s&load_inertia=6.4e-8&speed=max"
CHECK = ["check", "--product", "sim-disc", "--rig", "sim-line"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("url", "code", "word"),
    [
        (LINE, 0, "PASS"),
        (f"{LINE}&magnet=0.9", 1, "FAIL"),
        (f"{LINE}&fault=stall", 3, "INVALID"),
        (f"{LINE}&fault=unplug@0.3", 3, "INVALID"),
        (f"{LINE}&ambient=23&fault=drop:0.002@0.2", 4, "INVALID"),
    ],
)
def test_exit_codes(
    url: str, code: int, word: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    got = run([*CHECK, "--serial", "D000123", "--port", url, "-o", str(tmp_path), "--json"])
    said = capsys.readouterr()
    assert got == code, said.err + said.out
    assert json.loads(said.out)["outcome"] == word
    folder = next(tmp_path.iterdir())
    stored = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    assert stored["outcome"] == word
    assert {p.name for p in folder.iterdir()} >= {"junit.xml", "verdict.csv", "openhtf.json"}


def test_a_wrong_serial_number_moves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run([*CHECK, "--serial", "../x", "-o", str(tmp_path / "out")]) == 2
    assert "scan the label again" in capsys.readouterr().err
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.slow
def test_a_stored_capture_gets_the_same_verdict(
    good: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    call = ["check", "--product", "sim-disc", "--capture", str(good)]
    assert run(call) == 0
    page = capsys.readouterr().out
    assert "PASS" in page.splitlines()[7]
    assert "R_25" in page
    assert run([*call, "-o", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["serial"] == "D000001"
    assert len(list(tmp_path.iterdir())) == 1
    assert run([*call, "--serial", "D999999"]) == 2  # another motor's capture
    assert run(["check", "--product", "sim-disc"]) == 2


@pytest.mark.slow
def test_the_serial_number_comes_from_the_scanner(tmp_path: Path) -> None:
    call = [sys.executable, "-m", "motorid.cli.main", *CHECK, "--speed", "max", "-o", str(tmp_path)]
    done = subprocess.run(call, input="D000042\n", capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    assert "D000042" in done.stdout


@pytest.mark.slow
def test_repeated_inspections_stay_apart(line_rig: Rig, product: Product, tmp_path: Path) -> None:
    with Line(line_rig, product, tmp_path) as line:
        folders = {line.inspect("D000005").folder for _ in range(3)}
    assert len(folders) == 3


@pytest.mark.slow
def test_a_broken_link_is_opened_again(line_rig: Rig, product: Product, tmp_path: Path) -> None:
    with Line(line_rig, product, tmp_path) as line:
        line.rig = replace(line_rig, port=f"{line_rig.port}&fault=unplug@0.2")
        bad = line.inspect("D000005")
        line.rig = line_rig
        fine = line.inspect("D000005")
    assert (bad.exit_code, fine.exit_code) == (3, 0), (bad.verdict.reasons, fine.verdict.reasons)


@pytest.mark.slow
def test_resume_judges_what_was_left(
    line_rig: Rig, product: Product, tmp_path: Path, good: Path
) -> None:
    left = tmp_path / "D000001_20260101T000000"
    left.mkdir()
    (left / "capture.h5").write_bytes(good.read_bytes())
    torn = tmp_path / "D000002_20260101T000001"
    torn.mkdir()
    (torn / "capture.h5").write_bytes(good.read_bytes()[:3000])
    done = resume(tmp_path, product)
    assert [str(d.verdict.outcome) for d in done] == ["PASS", "INVALID"]
    assert done[1].verdict.serial == "D000002"
    assert resume(tmp_path, product) == []


@pytest.mark.slow
def test_cycle_time(
    line_rig: Rig, product: Product, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2 s a motor, of which the fit and the verdict may take 150 ms: so long the rig's own clock
    runs, and so often the model is computed. bench/bench_cycle.py takes the time of all of it.
    """
    true = truth(line_rig.port)
    assert true["J"] * true["R_25"] / true["K_25"] ** 2 == pytest.approx(20e-3, rel=0.01)
    computed: list[int] = []
    fitted = MotorRecord.fitted

    def counted(record: MotorRecord, *at: Any) -> Any:
        computed.append(1)
        return fitted(record, *at)

    monkeypatch.setattr(MotorRecord, "fitted", counted)
    with Line(line_rig, product, tmp_path) as line:
        line.warm()
        assert line._port is not None
        began = line._port.now()
        done = line.inspect("D000001")
        lasted_s = line._port.now() - began
    assert done.exit_code == 0
    assert set(done.seconds) == {"capture", "fit", "verdict", "records"}
    assert product.program.duration_s < lasted_s < 2.0 - 0.15
    assert 0 < len(computed) < 180  # twice of what it was when it took 130 ms
