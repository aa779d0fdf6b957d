"""Sensors that fail in mid-run are noticed by the capture itself; healthy ones never."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire import record
from motorid.acquire.doubts import doubts
from motorid.capture import store
from motorid.capture.model import CURRENT, POSITION, Capture, Channel, Phase
from motorid.cli.main import run as command
from motorid.program import Decay, Program, Step, StepKind, climbs
from tests.acquire.rigs import sim_rig

LONGER = climbs([[3.0, 6.0]], kind=StepKind.DRIVE_VOLTS, drive_s=0.2, coast_s=[0.2], rest_s=0.02)


def captured(options: str, path: Path, program: Program = LONGER) -> Capture:
    rig = sim_rig(options, program=program)
    return store.load(record.capture(rig, program, path / "run.h5"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "says"),
    [
        ("encoder_dead@0.6", "the encoder stands still from"),
        ("stall@0.6", "the encoder stands still from"),
        ("adc_stuck@0.6", "without a change from"),
    ],
)
def test_a_sensor_that_fails_in_mid_run_is_named(fault: str, says: str, tmp_path: Path) -> None:
    capture = captured(f"fault={fault}", tmp_path)
    assert capture.end_reason == "completed"
    notes = capture.provenance["notes"]
    assert says in notes[0]
    since = float(notes[0].split(" from ")[1].split(" s ")[0])
    assert 0 < since < capture.time_s[-1]


@pytest.mark.slow
def test_the_command_says_so_and_the_file_keeps_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["capture", "--rig", "sim", "--port", "sim://?speed=max&fault=adc_stuck@0.8"]
    assert command([*words, "-o", str(tmp_path / "run.h5")]) == 0
    said = capsys.readouterr().err.splitlines()
    assert any(line.startswith("note: current reads") for line in said)
    assert store.load(tmp_path / "run.h5").provenance["notes"]


@pytest.mark.slow
@pytest.mark.parametrize("options", ["", "noise=0", "noise=0.3", "noise=4", "seed=9&clock_ppm=40"])
def test_a_healthy_run_is_not_doubted(options: str, tmp_path: Path) -> None:
    assert "notes" not in captured(options, tmp_path).provenance


@pytest.mark.slow
@pytest.mark.parametrize("motor", ["maxon-re35", "pittman", "qube"])
def test_no_healthy_motor_is_doubted(motor: str, tmp_path: Path) -> None:
    from motorid.rig import load_rig

    name = {"maxon-re35": "sim-re35", "pittman": "sim-pittman", "qube": "sim-qube"}[motor]
    rig = load_rig(name)
    rig = replace(rig, port=f"{rig.port}&speed=max")
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert doubts(capture) == []


@pytest.mark.slow
def test_a_level_that_friction_beats_is_no_fault(tmp_path: Path) -> None:
    """The motor runs down to rest in a drive."""
    slow = Decay.SYNCHRONOUS_SLOW
    steps = [
        Step(StepKind.DRIVE_VOLTS, 0.2, 6.0, slow),
        Step(StepKind.DRIVE_VOLTS, 0.4, 0.02, slow),
    ]
    capture = captured("", tmp_path, Program(tuple(steps)))
    counts = np.asarray(capture.channels[POSITION].raw)
    assert np.ptp(counts[-500:]) <= 1
    assert doubts(capture) == []


@pytest.mark.parametrize("noise", [0.25, 0.5, 1.0, 3.0])
def test_noise_alone_repeats_itself_less(noise: float) -> None:
    rng = np.random.default_rng(1)
    raw = np.rint(2048 + rng.normal(0, noise, 300_000)).astype(np.int16)
    current = Channel(
        CURRENT, "A", raw, scale=0.01, offset=2048, resolution=0.01, noise=0.01 * noise
    )
    capture = Capture(np.arange(300_000) * 100, 1e6, {CURRENT: current})
    assert doubts(capture) == []
    raw[100_000:101_000] = 2048
    (said,) = doubts(capture)
    assert abs(float(said.split(" from ")[1].split(" s ")[0]) - 10.0) < 0.02


def test_ends_of_the_range_are_another_matter() -> None:
    raw = np.full(1000, 4095, np.int16)
    current = Channel(CURRENT, "A", raw, 0.01, resolution=0.01, noise=0.01, raw_max=4095)
    assert doubts(Capture(np.arange(1000) * 100, 1e6, {CURRENT: current})) == []


def test_phases_that_the_program_lacks_are_passed_over() -> None:
    position = Channel(POSITION, "rad", np.zeros(100, np.int64))
    plan = Program((Step(StepKind.COAST, 1.0),))
    phases = (Phase(0, 0), Phase(7, 50))
    capture = Capture(np.arange(100), 100.0, {POSITION: position}, program=plan, phases=phases)
    assert doubts(capture) == []
