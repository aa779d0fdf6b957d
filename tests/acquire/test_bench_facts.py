"""What a rig and its board contradict one another in is said before the motor turns."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire import record
from motorid.acquire.bench_facts import contradictions
from motorid.acquire.encoder_scale import judge_scale, why_too_fast
from motorid.acquire.pulse import Pulse
from motorid.capture import store
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Rig, load_rig
from motorid.rig_file import parse
from motorid.wire.enums import ChannelKind
from tests.acquire.rigs import run, sim_rig

IDENTITY = {"pwm_hz": 16_000, "clock_hz": 16_000_000}
IN_STEP = 2000  # ticks of a sample: two PWM periods
WEAK = Pulse(0.1, 0.7, 40, 0.05, 1e-3, 0.2, False, 0.69)


def said(rig: Rig, aperture_ns: int, read_v: float | None, period: int = IN_STEP) -> list[str]:
    fact = {"kind": ChannelKind.MEAN, "aperture_ns": aperture_ns}
    known = {"terminal_voltage": fact}
    return list(contradictions(rig, rig.program, IDENTITY, known, read_v, period))


def test_a_bench_that_agrees_says_nothing() -> None:
    assert said(sim_rig(), 62_500, 7.1) == []
    assert said(sim_rig(), 125_000, None) == []


def test_a_supply_that_reads_otherwise() -> None:
    (one,) = said(replace(sim_rig(), supply_voltage_v=9.0), 62_500, 7.0)
    assert "supply_voltage_v = 9" in one
    assert "7 V" in one


def test_a_window_over_part_of_a_pwm_period_in_step_with_the_samples() -> None:
    (one,) = said(sim_rig(), 100_000, 7.0)
    assert "1.6 periods of the 16000 Hz PWM" in one
    assert said(sim_rig(), 100_000, 7.0, period=1600) == []  # a beat of 6 kHz is noise


def test_the_level_that_is_read_the_most_wrong_for_its_size_is_named() -> None:
    """Instants of V = 8 V: at a duty d wrong by max(d, 1 - d) V, so that the lowest level is it."""
    levels = [
        Step(StepKind.DRIVE_VOLTS, 0.1, volts, Decay.SYNCHRONOUS_SLOW) for volts in (6.0, -2.0, 4.0)
    ]
    fact = {"kind": ChannelKind.INSTANT, "aperture_ns": 100_000}
    known = {"terminal_voltage": fact}
    rig = replace(sim_rig(program=Program(tuple(levels))), supply_voltage_v=8.0)
    (one,) = contradictions(rig, rig.program, IDENTITY, known, 8.0, IN_STEP)
    assert "sees an instant of the 16000 Hz PWM, so that 2 V may be read 6 V wrong" in one
    assert list(contradictions(rig, rig.program, IDENTITY | {"pwm_hz": 0}, known, 8.0, 1)) == []
    coast = Program((Step(StepKind.COAST, 0.1),))
    assert list(contradictions(rig, coast, IDENTITY, known, 8.0, IN_STEP)) == []


@pytest.mark.slow
def test_capture_says_it_before_it_runs_and_keeps_what_the_board_read(tmp_path: Path) -> None:
    rig = replace(sim_rig(), supply_voltage_v=9.0)
    heard: list[str] = []
    (path,) = record.capture_all(rig, rig.program, [tmp_path / "run.h5"], say=heard.append)
    assert any("supply_voltage_v = 9" in one for one in heard)
    capture = store.load(path)
    assert capture.supply_measured_v == pytest.approx(7.0, rel=0.01)
    assert capture.supply_v == capture.supply_measured_v


def test_a_supply_outside_its_own_limits_is_refused() -> None:
    text = load_rig("sim").text.replace("supply_voltage_v = 7.0", "supply_voltage_v = 12")
    with pytest.raises(RigError, match=r"supply_voltage_v = 12 is not within .* = 9: correct"):
        parse(text, "bench.toml")


# ---------------------------------------------------------------- the encoder's scale


def of_counts(counts: float) -> Rig:
    rig = sim_rig()
    return replace(rig, wiring=replace(rig.wiring, counts_per_turn=counts))


def test_a_weak_pulse_faster_than_its_voltage_allows_is_refused() -> None:
    counts_per_s = 70.0 / 6.2832 * 2048  # 70 rad/s, of 91 that 0.7 V can turn
    pulse = replace(WEAK, counts_per_s=counts_per_s)
    judge_scale(of_counts(2048), pulse)
    judge_scale(of_counts(8192), pulse)
    with pytest.raises(RigError, match=r"counts_per_turn = 512 is too small"):
        judge_scale(of_counts(512), pulse)


def test_without_a_nameplate_or_a_speed_nothing_is_said() -> None:
    rig = of_counts(512)
    judge_scale(rig, WEAK)
    plate = replace(rig.nameplate, torque_constant_nm_a=None)
    judge_scale(replace(rig, nameplate=plate), replace(WEAK, counts_per_s=1e6))


@pytest.mark.slow
def test_a_trip_of_the_speed_limit_says_what_the_encoder_cannot_mean(tmp_path: Path) -> None:
    capture = store.load(run("", tmp_path / "run.h5"))
    assert why_too_fast(sim_rig(), capture) == ""
    position = capture.channels["position"]
    doubled = replace(position, scale=2.0 * position.scale)
    wrong = replace(capture, channels={**capture.channels, "position": doubled})
    assert "times what nameplate.torque_constant_nm_a" in why_too_fast(of_counts(1024), wrong)
