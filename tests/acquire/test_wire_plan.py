"""A rig and a program in a board's integers, on both sides of what it can."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from motorid.acquire.drive import ADVICE, of_fault, tripped
from motorid.acquire.held_rotor import board_limit
from motorid.acquire.plan import (
    check_burst,
    configuration,
    is_fast,
    sample_period,
    step_ticks,
    wire_program,
)
from motorid.errors import RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.wire.codec import name_of
from motorid.wire.enums import Channel, ChannelKind, Fault
from tests.acquire.rigs import sim_rig

RIG = sim_rig()
IDENTITY: dict[str, Any] = {
    "board": "bench",
    "clock_hz": 1_000_000,
    "sample_period_step_ticks": 10,
    "min_sample_period_ticks": 200,
    "burst_sample_period_ticks": 30,
    "max_steps": 3,
    "decay_modes": 0b0110,
    "burst_samples": 100,
    "buffer_samples": 20,
    "encoder_edge_ceiling_hz": 10**6,
    "max_current_ma": 5000,
    "max_host_silence_ms": 300,
}
KNOWN = {name: {"kind": int(ChannelKind.MEAN)} for name in ("current", "position")}


def rig(rate_hz: float = 1000.0, mode: str = "stream", **limits: Any) -> Any:
    sampling = replace(RIG.sampling, rate_hz=rate_hz, mode=mode, channels=("current", "position"))
    wiring = replace(RIG.wiring, counts_per_turn=1000.0, gear_ratio=1.0)
    limits = {"speed_rad_s": 100.0, "voltage_v": None, "inputs": ()} | limits
    made = replace(RIG.limits, **limits)
    return replace(RIG, sampling=sampling, wiring=wiring, limits=made)


@pytest.mark.parametrize(
    ("rate_hz", "mode", "period"),
    [
        (1000.0, "stream", 1000),
        (998.0, "stream", 1000),  # in steps of ten ticks
        (994.0, "stream", 1010),
        (5000.0, "stream", 200),
        (5004.0, "stream", 200),
        (5004.0, "burst", 200),  # as near as a person rounds
        (5100.0, "burst", 30),
        (33_333.0, "burst", 30),
        (33_360.0, "burst", 30),
        (math.inf, "burst", 30),
    ],
)
def test_the_period_that_a_rig_asks_for(rate_hz: float, mode: str, period: int) -> None:
    assert sample_period(rig(rate_hz, mode), IDENTITY) == period


@pytest.mark.parametrize(
    ("rate_hz", "mode", "says"),
    [
        (6000.0, "stream", r'at 5000 Hz at most: lower it, or set sampling\.mode = "burst".*33333'),
        (math.inf, "stream", "samples at 5000 Hz at most"),
        (34_000.0, "burst", r"samples at 33333\.3 Hz at most: lower it$"),
        (1e-4, "stream", "too slow for this board"),
    ],
)
def test_a_period_that_a_board_cannot_do(rate_hz: float, mode: str, says: str) -> None:
    with pytest.raises(RigError, match=says):
        sample_period(rig(rate_hz, mode), IDENTITY)


def test_a_board_without_a_fast_burst_does_what_a_stream_does() -> None:
    slow = {name: one for name, one in IDENTITY.items() if name != "burst_sample_period_ticks"}
    assert sample_period(rig(math.inf, "burst"), slow) == 200
    with pytest.raises(RigError, match=r"samples at 5000 Hz at most: lower it$"):
        sample_period(rig(6000.0, "burst"), slow)
    with pytest.raises(RigError, match=r"samples at 5000 Hz at most: lower it$"):
        sample_period(rig(6000.0), slow)
    assert sample_period(rig(), IDENTITY | {"sample_period_step_ticks": 0}) == 1000


@pytest.mark.parametrize(
    ("period", "fast", "ticks"),
    [(30, True, 600), (199, True, 39_800), (200, False, 200), (250, False, 250)],
)
def test_the_steps_of_a_fast_burst_are_those_of_the_guard_too(
    period: int, fast: bool, ticks: int
) -> None:
    assert is_fast(period, IDENTITY) is fast
    assert step_ticks(period, IDENTITY) == ticks


def test_the_configuration_s_integers() -> None:
    limits = {"supply_min_v": 5.4, "supply_max_v": 12.6, "run_time_s": 3.0, "host_silence_s": 0.2}
    found = configuration(rig(current_a=1.2345, **limits), IDENTITY, KNOWN)
    assert found == {
        "sample_period_ticks": 1000,
        "channels": 1 << Channel.CURRENT | 1 << Channel.POSITION,
        "mode": 0,
        "encoder_reversed": 0,
        "current_limit_ma": 1234,
        "speed_limit_counts_s": 15_915,  # 100 rad/s of 1000 counts a turn
        "supply_min_mv": 5400,
        "supply_max_mv": 12_600,
        "run_time_limit_ms": 3000,
        "host_silence_ms": 200,
    }


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        ({"current_a": 5.001}, "above the 5 A that the board accepts"),
        ({"run_time_s": 5e6}, "run_time_s does not fit the protocol's 32 bits"),
        ({"speed_rad_s": 6284.0}, "means 1000130 encoder edges a second.*lower it to 6283 or less"),
    ],
)
def test_what_a_board_does_not_take(limits: dict[str, float], says: str) -> None:
    with pytest.raises(RigError, match=says):
        configuration(rig(**limits), IDENTITY, KNOWN)


def test_limits_that_a_board_just_takes() -> None:
    found = configuration(
        rig(current_a=5.0, run_time_s=4_294_967.295, speed_rad_s=6283.0), IDENTITY, KNOWN
    )
    assert (found["current_limit_ma"], found["run_time_limit_ms"]) == (5000, 2**32 - 1)


def test_a_way_of_reading_that_nobody_knows_is_refused() -> None:
    with pytest.raises(RigError, match=r"reads position in a way .* know \(9\)"):
        configuration(rig(), IDENTITY, KNOWN | {"position": {"kind": 9}})


# -- programs
def steps(*made: Step) -> Program:
    return Program(made)


def test_levels_are_in_millionths_and_millivolts() -> None:
    slow = Decay.SYNCHRONOUS_SLOW
    program = steps(
        Step(StepKind.DRIVE_DUTY, 0.0104, -0.25, slow),
        Step(StepKind.BRAKE, 0.0006),
        Step(StepKind.DRIVE_VOLTS, 1e-5, 1.5, slow),
    )
    wire = wire_program(program, IDENTITY, 1000)
    assert [(one["index"], one["level"], one["ticks"]) for one in wire.steps] == [
        (0, -250_000, 10_000), (1, 0, 1000), (2, 1500, 1000),
    ]  # fmt: skip
    assert wire.origin == (0, 1, 2)
    assert wire.ticks == 12_000


def test_a_step_of_more_than_32_bits_is_cut_in_whole_periods() -> None:
    wire = wire_program(steps(Step(StepKind.BRAKE, 9000.0)), IDENTITY, 1000)
    longest = 4_294_967_000
    assert [one["ticks"] for one in wire.steps] == [longest, longest, 9 * 10**9 - 2 * longest]
    assert [one["index"] for one in wire.steps] == [0, 1, 2]
    assert wire.origin == (0, 0, 0)


def test_a_board_holds_so_many_steps() -> None:
    brake = Step(StepKind.BRAKE, 1.0)
    assert len(wire_program(steps(*[brake] * 3), IDENTITY, 1000).steps) == 3
    with pytest.raises(RigError, match="more than the 3 steps that the board bench"):
        wire_program(steps(*[brake] * 4), IDENTITY, 1000)


@pytest.mark.parametrize("decay", [Decay.SYNCHRONOUS_SLOW, Decay.DIODE, Decay.FAST])
def test_a_board_has_some_ways_of_decay(decay: Decay) -> None:
    program = steps(Step(StepKind.BRAKE, 1.0), Step(StepKind.DRIVE_VOLTS, 1.0, 1.0, decay))
    if decay is Decay.FAST:
        with pytest.raises(RigError, match="step 1 of the program asks for fast decay"):
            wire_program(program, IDENTITY, 1000)
    else:
        assert wire_program(program, IDENTITY, 1000).steps[1]["decay"] == int(decay)


@pytest.mark.parametrize(
    ("period", "samples", "good"),
    [(30, 100, True), (30, 101, False), (200, 20, True), (200, 21, False)],
)
def test_a_burst_fits_the_board_s_memory(period: int, samples: int, good: bool) -> None:
    wire = wire_program(steps(Step(StepKind.BRAKE, samples * period / 1e6)), IDENTITY, period)
    check_burst(rig(mode="stream"), wire, IDENTITY, period)
    if good:
        check_burst(rig(mode="burst"), wire, IDENTITY, period)
    else:
        most, longest = (100, 3) if period == 30 else (20, 4)
        with pytest.raises(
            RigError, match=f"keeps {most} in burst mode: shorten it to {longest} ms"
        ):
            check_burst(rig(mode="burst"), wire, IDENTITY, period)


# -- trips
@pytest.mark.parametrize("fault", ADVICE)
def test_a_trip_in_a_sentence(fault: Fault) -> None:
    name = name_of(Fault, fault)
    assert tripped(f"fault: {name}") == (
        f"the board tripped ({name}) and opened the bridge: {ADVICE[fault]}"
    )
    assert tripped(f"fault: {name}", "of X").startswith(f"the board tripped ({name}: of X) and")


def test_a_trip_that_nobody_knows() -> None:
    assert tripped("fault: 77").endswith("see the documentation of its firmware")
    assert of_fault({"fault": Fault.OVER_CURRENT, "value": 1}) == ""
    found = of_fault({"fault": Fault.WRONG_SIGN, "value": int(Channel.POSITION)})
    assert found == "position"


# -- a rotor that is held
@pytest.mark.parametrize(("period", "samples"), [(1000, 2), (100, 15), (150, 13), (5000, 1)])
def test_the_limit_is_of_the_allowed_counts_in_the_window_of_a_board(
    period: int, samples: int
) -> None:
    # 3 counts of 1000 a turn, over a window of about 2 ms and 15 samples at most
    limit = board_limit(rig(speed_rad_s=1000.0), IDENTITY, period)["speed_limit_counts_s"]
    assert limit == math.ceil(3 * 1e6 / (samples * period))


def test_the_limit_of_a_held_rotor_is_never_above_the_rig_s_or_the_board_s() -> None:
    assert board_limit(rig(speed_rad_s=2.0), IDENTITY, 1000) == {"speed_limit_counts_s": 318}
    tight = IDENTITY | {"encoder_edge_ceiling_hz": 77}
    assert board_limit(rig(), tight, 1000) == {"speed_limit_counts_s": 77}
