"""A fast burst, from a rig to a capture: 80 kHz on the simulated board."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.acquire.plan import sample_period
from motorid.acquire.record import capture
from motorid.capture.model import CURRENT
from motorid.capture.store import load
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.workflow.record import bursting
from tests.acquire.rigs import run, sim_rig

RATE_HZ = 80_000
START = Program(
    (
        Step(StepKind.COAST, 1e-3),
        Step(StepKind.DRIVE_DUTY, 3e-3, 1.0, Decay.SYNCHRONOUS_SLOW),
        Step(StepKind.COAST, 2e-3),
    )
)


@pytest.mark.slow
def test_a_burst_is_faster_than_a_stream_and_reads_the_same_motor(tmp_path: Path) -> None:
    rig = bursting(sim_rig("heating=0"))
    burst = load(capture(rig, START, tmp_path / "burst.h5"))
    assert len(burst) == round(RATE_HZ * START.duration_s)
    assert np.ptp(np.diff(burst.ticks)) == 0
    assert 1 / np.diff(burst.time_s).mean() == pytest.approx(RATE_HZ, rel=1e-3)
    assert (burst.gaps, burst.end_reason) == ((), "completed")
    current = burst.channels[CURRENT]
    assert (current.kind, current.aperture_s, current.pwm_phase) == ("instant", 0.0, None)
    # The start of the current is L's: U/L (1 - t/2 tau) over the first 25 us at 7 V.
    first = burst.phases[1].tick
    began = int(np.searchsorted(burst.ticks, first))
    rise = (current.values[began + 2] - current.values[began]) / (2 / RATE_HZ)
    volts = burst.channels["terminal_voltage"].values[began + 1 : began + 3].mean()
    slope = volts / 180e-6 * (1 - 12.5e-6 / 69.2e-6)
    assert rise == pytest.approx(slope, rel=0.1)


@pytest.mark.slow
def test_a_rate_above_a_stream_s_means_the_fast_burst(tmp_path: Path) -> None:
    rig = sim_rig()
    fast = replace(rig, sampling=replace(rig.sampling, mode="burst", rate_hz=RATE_HZ))
    burst = load(capture(fast, START, tmp_path / "burst.h5"))
    assert 1 / np.diff(burst.time_s).mean() == pytest.approx(RATE_HZ, rel=1e-3)
    streamed = replace(rig, sampling=replace(rig.sampling, rate_hz=RATE_HZ))
    with pytest.raises(RigError, match=r'set sampling.mode = "burst" .* at 80000 Hz'):
        capture(streamed, START, tmp_path / "stream.h5")
    beyond = replace(rig, sampling=replace(rig.sampling, mode="burst", rate_hz=2 * RATE_HZ))
    with pytest.raises(RigError, match="samples at 80000 Hz at most"):
        capture(beyond, START, tmp_path / "beyond.h5")


BOARD = {
    "board": "b", "clock_hz": 8_000_000, "sample_period_step_ticks": 1,
    "min_sample_period_ticks": 400, "burst_sample_period_ticks": 96,
}  # fmt: skip


@pytest.mark.parametrize(
    ("rate_hz", "ticks"),
    [
        (20_000.0, 400),
        (20_010.0, 400),  # of a stream that a person rounds up
        (20_100.0, 96),
        (83_333.0, 96),
        (83_400.0, 96),  # 8 MHz over 96, rounded up
        (math.inf, 96),
    ],
)
def test_a_burst_is_the_fast_one_only_where_a_stream_is_too_slow(
    rate_hz: float, ticks: int
) -> None:
    rig = sim_rig()
    rig = replace(rig, sampling=replace(rig.sampling, mode="burst", rate_hz=rate_hz))
    assert sample_period(rig, BOARD) == ticks


def test_a_burst_faster_than_a_rounded_rate_is_refused() -> None:
    rig = sim_rig()
    rig = replace(rig, sampling=replace(rig.sampling, mode="burst", rate_hz=83_500.0))
    with pytest.raises(RigError, match="samples at 83333"):
        sample_period(rig, BOARD)


def test_a_program_that_the_memory_does_not_hold_is_refused(tmp_path: Path) -> None:
    rig = bursting(sim_rig("buffer=200"))
    with pytest.raises(RigError, match=r"480 samples.*keeps 200 .*shorten it to 2.5 ms"):
        capture(rig, START, tmp_path / "burst.h5")
    assert not list(tmp_path.glob("*.h5"))


@pytest.mark.slow
def test_a_board_without_one_bursts_at_its_best(tmp_path: Path) -> None:
    rig = bursting(sim_rig("burst=1"))
    burst = load(capture(rig, START, tmp_path / "burst.h5"))
    assert 1 / np.diff(burst.time_s).mean() == pytest.approx(20_000, rel=1e-3)


@pytest.mark.slow
def test_a_stream_after_it_is_as_ever(tmp_path: Path) -> None:
    streamed = load(run("", tmp_path / "run.h5"))
    assert streamed.channels[CURRENT].kind == "mean"
