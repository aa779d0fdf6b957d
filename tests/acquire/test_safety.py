"""What is refused before anything turns."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from motorid.acquire.plan import configuration, differing, wire_program
from motorid.acquire.safety import check_program, pulse_resistance
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Nameplate, Rig
from motorid.wire.hashes import config_hash
from tests.acquire.rigs import sim_rig

IDENTITY = {
    "board": "bench",
    "clock_hz": 16_000_000,
    "sample_period_step_ticks": 800,
    "min_sample_period_ticks": 800,
    "encoder_edge_ceiling_hz": 2_000_000,
    "max_current_ma": 5000,
    "max_host_silence_ms": 300,
    "decay_modes": 0b0010,
    "max_steps": 8,
    "buffer_samples": 100,
}
CHANNELS: dict[str, Any] = {"current": {}, "terminal_voltage": {}, "position": {}}


def volts(*levels: float, seconds: float = 1.0) -> Program:
    """Levels in turn; None coasts."""
    return Program(
        tuple(
            Step(StepKind.DRIVE_VOLTS, seconds, level, Decay.SYNCHRONOUS_SLOW) for level in levels
        )
    )


def rig(**limits: float) -> Rig:
    bench = sim_rig()
    return replace(bench, limits=replace(bench.limits, **limits))


def test_the_rig_s_own_program_passes() -> None:
    bench = rig()
    check_program(bench, bench.program)


def test_a_level_whose_locked_current_passes_the_limit_is_refused() -> None:
    bench = rig(current_a=2.0)  # 6 V / 2.6 ohm = 2.31 A
    with pytest.raises(RigError, match=r"6 V\) could draw 2\.31 A through 2\.6 ohm"):
        check_program(bench, volts(6.0))
    check_program(bench, volts(5.0))


def test_a_reversal_counts_the_back_emf() -> None:
    bench = rig(current_a=3.0)
    check_program(bench, volts(5.0))
    with pytest.raises(RigError, match=r"step 1 .* could draw 3\.85 A"):
        check_program(bench, volts(5.0, -5.0))


def test_a_long_enough_brake_makes_a_reversal_safe() -> None:
    bench = rig(current_a=3.0)
    brake = Step(StepKind.BRAKE, 0.5)
    drive, back = volts(5.0, -5.0).steps
    check_program(bench, Program((drive, brake, back)))
    short = replace(brake, duration_s=0.001)
    with pytest.raises(RigError, match="step 2"):
        check_program(bench, Program((drive, short, back)))


def test_without_a_resistance_the_pulse_gives_one() -> None:
    bench = replace(rig(), nameplate=Nameplate(voltage_v=6.0))
    check_program(bench, volts(6.0))
    with pytest.raises(RigError, match="could draw"):
        check_program(bench, volts(6.0), resistance_ohm=pulse_resistance(0.7, 0.6))


def test_a_duty_counts_as_its_share_of_the_measured_supply() -> None:
    bench = rig(current_a=2.0)
    full = Program((Step(StepKind.DRIVE_DUTY, 1.0, 0.9, Decay.DIODE),))
    check_program(bench, full, supply_v=5.0)
    with pytest.raises(RigError, match="could draw"):
        check_program(bench, full, supply_v=7.0)


@pytest.mark.parametrize(
    ("limits", "program", "says"),
    [
        ({"run_time_s": 1.5}, volts(3.0, 3.0), "limits.run_time_s is 1.5"),
        ({"speed_rad_s": 500}, volts(6.0), "limits.speed_rad_s is 500"),
        ({}, volts(9.0), "the supply has 7 V"),
    ],
)
def test_other_limits(limits: dict[str, float], program: Program, says: str) -> None:
    with pytest.raises(RigError) as caught:
        check_program(rig(**limits), program)
    assert says in str(caught.value)


def test_the_configuration_in_the_board_s_integers() -> None:
    fields = configuration(rig(), IDENTITY, CHANNELS)
    assert fields["sample_period_ticks"] == 1600
    assert fields["channels"] == 0b1011
    assert fields["current_limit_ma"] == 3200
    assert fields["speed_limit_counts_s"] == 358_544  # 1100 rad/s of 2048 counts a turn
    assert fields["host_silence_ms"] == 300  # the board's longest


def test_the_speed_limit_is_the_motor_s_and_the_encoder_may_sit_after_a_gear() -> None:
    bench = rig()
    geared = replace(bench, wiring=replace(bench.wiring, gear_ratio=10.0))
    assert configuration(geared, IDENTITY, CHANNELS)["speed_limit_counts_s"] == 35_854


@pytest.mark.parametrize(
    ("identity", "says"),
    [
        ({"encoder_edge_ceiling_hz": 100_000}, "lower it to 307 or less"),
        ({"max_current_ma": 1000}, "above the 1 A that the board accepts"),
        ({"min_sample_period_ticks": 16_000}, "samples at 1000 Hz at most"),
    ],
)
def test_a_board_that_cannot_says_so(identity: dict[str, int], says: str) -> None:
    with pytest.raises(RigError) as caught:
        configuration(rig(), IDENTITY | identity, CHANNELS)
    assert says in str(caught.value)


def test_a_channel_that_the_board_lacks_is_named() -> None:
    with pytest.raises(RigError, match="asks for terminal_voltage, which the board bench has not"):
        configuration(rig(), IDENTITY, {"current": {}, "position": {}})


MINOR = 3


def test_what_reads_back_otherwise_is_named() -> None:
    sent = configuration(rig(), IDENTITY, CHANNELS)
    right = sent | {"config_hash": config_hash(sent)}
    old = right | {"config_hash": config_hash(sent, 2)}
    assert differing(sent, old, 2) is None
    assert "hash" in str(differing(sent, old, MINOR))
    assert differing(sent, right, MINOR) is None
    assert differing(sent, right | {"current_limit_ma": 9}, MINOR) == (
        "current_limit_ma was sent as 3200 and reads back as 9"
    )
    assert "hash" in str(differing(sent, right | {"config_hash": 1}, MINOR))


def test_a_program_in_ticks() -> None:
    wire = wire_program(volts(-1.2345, seconds=0.01), IDENTITY, 1600)
    assert wire.steps == ({"index": 0, "kind": 2, "decay": 1, "level": -1234, "ticks": 160_000},)


def test_a_step_longer_than_32_bits_goes_as_several() -> None:
    wire = wire_program(Program((Step(StepKind.COAST, 600.0),)), IDENTITY, 1600)
    assert wire.origin == (0, 0, 0)
    assert wire.ticks == 600 * 16_000_000
    assert all(step["ticks"] % 1600 == 0 for step in wire.steps)


def test_what_the_board_cannot_run_is_refused() -> None:
    with pytest.raises(RigError, match="diode decay"):
        wire_program(Program((Step(StepKind.DRIVE_DUTY, 1, 0.5, Decay.DIODE),)), IDENTITY, 1600)
    with pytest.raises(RigError, match="more than the 8 steps"):
        wire_program(volts(*[1.0] * 9), IDENTITY, 1600)
