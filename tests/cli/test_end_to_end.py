"""The commands themselves, from rig to report, on the simulated board."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest

from motorid.cli import main
from motorid.rig_file import find
from motorid.workflow.plan_file import with_program
from tests.acquire.rigs import SHORT

FAST = ("--rig", "sim", "--speed", "max")


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, ...]:
    """FAST with a program of 0.4 s, where no figure of the answer is tested."""
    path = tmp_path_factory.mktemp("rigs") / "short.toml"
    path.write_text(with_program(find("sim").read_text(encoding="utf-8"), SHORT, "these tests"))
    return ("--rig", str(path), "--speed", "max")


@pytest.fixture(scope="module")
def capture_file(quick: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("captures") / "run.h5"
    assert main.run(["capture", *quick, "-o", str(path), "--serial", "M17"]) == 0
    return path


def run(*line: str | Path) -> int:
    return main.run([str(word) for word in line])


@pytest.mark.slow
def test_run_writes_capture_estimate_and_report(
    quick: tuple[str, ...],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "96")  # a narrow terminal gets no meanings
    out = tmp_path / "new folder" / "Ωut"
    assert run("run", *quick, "-o", out) == 0
    assert {p.name for p in out.iterdir()} == {"capture.h5", "estimate.json", "report.html"}
    printed = capsys.readouterr()
    assert "torque constant" in printed.out
    assert "report.html" in printed.err
    assert run("run", *quick, "-o", out) == 2
    assert run("run", *quick, "-o", out, "--force") == 0


@pytest.mark.slow
def test_fit_prints_json_alone(capture_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("fit", capture_file, "--json", "--fix", "K=0.0077", "--model", "six") == 0
    estimate = json.loads(capsys.readouterr().out)
    assert list(estimate["parameters"])[:6] == ["R", "L", "K", "B", "J", "T0"]
    assert estimate["parameters"]["K"]["status"] == "fixed"
    assert estimate["parameters"]["K"]["value"] == 0.0077


@pytest.mark.slow
def test_a_saved_capture_fits_as_the_live_one_did(
    quick: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("run", *quick, "-o", tmp_path) == 0
    capsys.readouterr()
    assert run("fit", tmp_path / "capture.h5", "--json") == 0
    again = json.loads(capsys.readouterr().out)
    live = json.loads((tmp_path / "estimate.json").read_text(encoding="utf-8"))
    assert again["parameters"] == live["parameters"]


@pytest.mark.slow
def test_repeat_makes_a_file_a_run_and_fit_takes_them_together(
    quick: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("capture", *quick, "-o", tmp_path / "m.h5", "--repeat", "2") == 0
    assert {p.name for p in tmp_path.iterdir()} == {"m-1.h5", "m-2.h5"}
    capsys.readouterr()
    assert run("fit", tmp_path / "m-1.h5", tmp_path / "m-2.h5", "--model", "six", "--json") == 0
    assert len(json.loads(capsys.readouterr().out)["inputs"]) == 2


@pytest.mark.slow
def test_segment_prints_a_table_and_draws_a_page(
    capture_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "segments.html"
    assert run("segment", capture_file, "--plot", page) == 0
    table = capsys.readouterr().out
    assert {"acceleration", "steady", "coast", "rest"} <= set(table.split())
    assert "<svg" in page.read_text(encoding="utf-8")
    assert run("segment", capture_file, "--plot", page) == 2  # it exists


def test_import_then_fit_says_what_the_file_can_tell(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "log.csv"
    rows = [f"{t / 100:.2f};{1500 + t % 7};{0.21 + 0.01 * (t % 3)}" for t in range(500)]
    log.write_text("t;n;i\n" + "\n".join(rows) + "\n", encoding="utf-8")
    out = tmp_path / "log.h5"
    maps = ("--map", "time=t:s", "--map", "speed=n:rpm", "--map", "current=i:A")
    assert run("import", log, *maps, "-o", out) == 0
    assert run("import", log, *maps, "-o", out) == 2
    assert run("import", log, "--map", "time=zeit:s", "--map", "speed=n:rpm", "-o", "x.h5") == 2
    errors = capsys.readouterr().err
    assert "zeit" in errors


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["empty", "text", "foreign", "truncated"])
def test_a_file_that_is_no_capture(
    kind: str, capture_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = tmp_path / "bad.h5"
    if kind == "foreign":
        with h5py.File(bad, "w") as file:
            file["x"] = [1, 2, 3]
    else:
        whole = capture_file.read_bytes()
        bad.write_bytes({"empty": b"", "text": b"hello", "truncated": whole[:9000]}[kind])
    for command in ("fit", "segment"):
        assert run(command, bad) == 4
        error = capsys.readouterr().err
        assert "bad.h5" in error
        assert error.count("\n") == 1


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (("capture", "--rig", "no-such-rig", "-o", "x.h5"), 3),
        (("capture", "--rig", "sim", "--port", "/dev/no-such-port", "-o", "x.h5"), 3),
        (("capture", "--rig", "sim", "--port", "carrier-pigeon://x", "-o", "x.h5"), 2),
        (("recover", "absent.h5"), 4),
    ],
)
def test_nothing_to_drive(
    line: tuple[str, ...],
    code: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(*line) == code
    assert capsys.readouterr().err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_an_existing_capture_stays(
    capture_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "precious.h5"
    path.write_bytes(b"precious")
    assert run("capture", *FAST, "-o", path) == 2
    assert path.read_bytes() == b"precious"
    assert "--force" in capsys.readouterr().err


def test_ports_and_rigs(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("ports") == 0
    assert run("rigs") == 0
    assert "sim" in capsys.readouterr().out.split()


def started(*line: str | Path) -> subprocess.Popen[str]:
    """A command in a process of its own, to be interrupted.

    A shell's background job ignores Ctrl-C, and so would its children: here it counts again.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return subprocess.Popen(
            [sys.executable, "-m", "motorid.cli.main", *map(str, line)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="Windows sends no SIGINT to one process")
def test_ctrl_c_keeps_what_was_measured(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    port = "sim://?speed=realtime"
    process = started("capture", "--rig", "sim", "--port", port, "-o", path)
    journal = wait_for(tmp_path, ".journal")
    while journal.stat().st_size < 50_000 and process.poll() is None:  # well into the run
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "run.h5" in error
    assert "Traceback" not in error
    with h5py.File(path) as file:
        assert len(file["samples/tick"]) > 0
    assert list(tmp_path.iterdir()) == [path]


def wait_for(folder: Path, suffix: str, seconds: float = 120.0) -> Path:
    """The first file of that suffix to appear."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        for path in folder.iterdir():
            if path.name.endswith(suffix):
                return path
        time.sleep(0.02)
    raise AssertionError(f"no {suffix} appeared in {seconds} s")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="pseudo terminals are POSIX")
def test_sim_on_a_pseudo_terminal_is_a_board_for_another_program(tmp_path: Path) -> None:
    served = started("sim", "--pty")
    try:
        assert served.stdout is not None
        device = served.stdout.readline().split()[-1]
        path, patient = tmp_path / "pty.h5", tmp_path / "patient.toml"
        # either process may wait for a core longer than the board bears to hear nothing
        text = find("sim").read_text(encoding="utf-8")
        patient.write_text(text.replace("[limits]", "[limits]\nhost_silence_s = 20"))
        captured = started("capture", "--rig", patient, "--port", device, "-o", path)
        _, error = captured.communicate(timeout=120)
        assert captured.returncode == 0, error
        with h5py.File(path) as file:
            assert len(file["samples/tick"]) > 1000
    finally:
        served.send_signal(signal.SIGINT)
        served.wait(timeout=120)
    assert served.returncode == 0  # Ctrl-C is how it ends
