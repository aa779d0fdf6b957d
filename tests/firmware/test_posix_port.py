"""The third port, written from docs/porting.md, passes the conformance suite as a device does."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PORT = ROOT / "firmware" / "ports" / "posix"
AT_ONCE = 2  # boards; each has a pytest, which takes a second to begin
FIRST, ALL = 90, 170  # tests of the suite that a real board can be put through, at least


@pytest.fixture(scope="module")
def binary(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The board as a program of this computer."""
    if sys.platform == "win32" or not shutil.which("make") or not shutil.which("gcc"):
        pytest.skip("no make and gcc: the firmware's host port is not built")
    folder = tmp_path_factory.mktemp("posix")
    done = subprocess.run(
        ["make", "-s", "-C", str(PORT), f"OUT={folder}"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return folder / "board"


@contextmanager
def running(binary: Path) -> Iterator[str]:
    """The name of the pseudo terminal behind which a board is."""
    process = subprocess.Popen([binary], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        yield process.stdout.readline().strip()
    finally:
        process.kill()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()


@pytest.fixture
def device(binary: Path) -> Iterator[str]:
    """One such name."""
    with running(binary) as name:
        yield name


def suite(device: str, modules: Sequence[Path], folder: Path, *more: str) -> str:
    """What pytest says of these modules of the conformance suite on that device."""
    command = [sys.executable, "-m", "pytest", *map(str, modules), "-q", "-p", "no:xdist"]
    words = ["-k", "device", "--device", device, "-o", f"cache_dir={folder}", "--tb=short", *more]
    # this pytest's own options: with one more -q there is no count to read
    env = {name: value for name, value in os.environ.items() if name != "PYTEST_ADDOPTS"}
    done = subprocess.run([*command, *words], capture_output=True, text=True, cwd=ROOT, env=env)
    return done.stdout


def counted(said: str) -> tuple[int, bool]:
    """How many cases passed by what pytest said, and whether any did not."""
    *_, summary = said.strip().splitlines() or [""]
    (count,) = map(int, re.findall(r"(\d+) passed", summary)[-1:] or ["0"])
    return count, bool(re.search(r"\d+ (failed|error)|^no tests ran", summary))


def passed(binary: Path, modules: Sequence[Path], folder: Path, *more: str) -> tuple[int, bool]:
    """How many cases of these modules passed on a board of their own, and whether any did not."""
    with running(binary) as device:
        return counted(suite(device, modules, folder, *more))


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize(
    ("rows", "least"),
    [
        pytest.param(("--first-rows",), FIRST, id="first rows"),
        pytest.param((), ALL, id="every row", marks=pytest.mark.study),
    ],
)
def test_it_passes_the_conformance_suite(
    binary: Path, tmp_path: Path, rows: tuple[str, ...], least: int
) -> None:
    """Several boards at once, for a test waits on its board nearly all of its time. The board is in
    real time: what a busy computer spoils is tried once more, by itself.
    """
    modules = sorted((ROOT / "tests" / "conformance").glob("test_*.py"))
    shares = [modules[k::AT_ONCE] for k in range(AT_ONCE)]
    folders = [tmp_path / f"cache-{k}" for k in range(AT_ONCE)]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        seen = list(pool.map(lambda *one: passed(binary, *one, *rows), shares, folders))
    counts = [count for count, _ in seen]
    for share, folder, (_, spoilt) in zip(shares, folders, seen, strict=True):
        if spoilt:
            with running(binary) as device:
                said = suite(device, share, folder, "--last-failed", *rows)
            count, spoilt = counted(said)
            assert not spoilt, said[-4000:]
            counts.append(count)
    assert sum(counts) >= least


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
