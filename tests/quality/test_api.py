"""The calls of a QA script, and the examples that show them."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import motorid
from motorid.quality.product import Product
from motorid.rig import Rig

NO_OPENHTF = "openhtf is not installed (pip install openhtf); it is an option of the examples"
FAST = "sim://?motor=faulhaber-2338s006s&load_inertia=6.4e-8&speed=max"


@pytest.mark.slow
def test_connect_run_fit_judge(line_rig: Rig, product: Product, tmp_path: Path) -> None:
    with motorid.connect(line_rig) as board:
        first = board.run(product.program, serial="D000007")
        second = board.run(product.program, path=tmp_path / "kept.h5", serial="D000007")
        assert Path(first.path).exists()
    assert not Path(first.path).exists()
    assert (tmp_path / "kept.h5").exists()
    verdict = motorid.judge(motorid.fit(first, second), product)
    assert verdict.outcome == "PASS", verdict.reasons
    assert verdict.serial == "D000007"
    assert motorid.judge(motorid.fit(second, model="six"), "sim-disc")["K_25"].outcome == "PASS"
    with pytest.raises(motorid.MotoridError, match="closed"):
        board.run()


@pytest.fixture
def environment(repo_root: Path, tmp_path: Path) -> dict[str, str]:
    """The simulated line at full speed, for the examples."""
    text = (repo_root / "rigs" / "sim-line.toml").read_text(encoding="utf-8")
    lines = [f'port = "{FAST}"' if x.startswith("port") else x for x in text.splitlines()]
    rig = tmp_path / "fast.toml"
    rig.write_text("\n".join(lines), encoding="utf-8")
    names = {"MOTORID_RIG": str(rig), "MOTORID_SERIAL": "D000123"}
    own = {key: value for key, value in os.environ.items() if key != "PYTEST_ADDOPTS"}
    return {**own, **names, "MOTORID_RECORDS": str(tmp_path)}


@pytest.mark.slow
@pytest.mark.long
def test_the_pytest_example(repo_root: Path, environment: dict[str, str]) -> None:
    example = repo_root / "docs" / "examples" / "pytest_motor.py"
    call = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(example)]
    done = subprocess.run(call, env=environment, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout
    limits = len(motorid.load_product("sim-disc").limits)
    assert f"{limits + 1} passed" in done.stdout, done.stdout  # and the verdict
    wrong = {**environment, "MOTORID_SERIAL": "WRONG"}
    done = subprocess.run(call, env=wrong, capture_output=True, text=True, timeout=240)
    assert done.returncode == 1
    assert "scan the label again" in done.stdout


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("openhtf") is None, reason=NO_OPENHTF)
def test_the_openhtf_example(repo_root: Path, environment: dict[str, str], tmp_path: Path) -> None:
    example = repo_root / "docs" / "examples" / "openhtf_motor.py"
    call = [sys.executable, str(example), "D000123"]
    done = subprocess.run(call, env=environment, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout + done.stderr
    theirs = json.loads(next(tmp_path.glob("D000123.*.json")).read_text(encoding="utf-8"))
    assert theirs["outcome"] == "PASS"
    measured = {k: v for phase in theirs["phases"] for k, v in phase["measurements"].items()}
    assert measured["R_25"]["measured_value"] == pytest.approx(2.6, rel=0.01)
    assert_ours_has_their_form(theirs)


def assert_ours_has_their_form(theirs: dict[str, object]) -> None:
    """Every key of motorid's own record is one that OpenHTF writes, at all three levels."""
    from motorid.quality.limits import Limit
    from motorid.quality.records import to_openhtf
    from motorid.quality.verdict import Reading, Verdict, decide

    limit = Limit("R_25", "ohm", 2.4, 2.8)
    ours = to_openhtf(Verdict("p", "s", (decide(limit, Reading("ohm", 2.6, 0.01), "R"),)))
    assert set(ours) <= set(theirs)
    phases = [p for p in theirs["phases"] if "R_25" in p["measurements"]]  # type: ignore[attr-defined]
    assert set(ours["phases"][0]) <= set(phases[0])
    mine = ours["phases"][0]["measurements"]["R_25"]
    assert set(mine) - {"units", "marginal", "docstring"} <= set(phases[0]["measurements"]["R_25"])
