"""What a board says of itself and what a rig asks of it, held against reason: by made figures."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from motorid.acquire.encoder_scale import judge_scale
from motorid.acquire.facts import wrong_descriptor, wrong_identity, wrong_zero
from motorid.acquire.guards import brown_out, guards, has, lacking, signs
from motorid.acquire.header import check_kinds
from motorid.acquire.held_program import heat_j
from motorid.acquire.pulse import Pulse
from motorid.acquire.safety import program_volts
from motorid.errors import DataError, RigError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Nameplate
from motorid.wire.enums import ChannelKind, Feature
from tests.acquire.rigs import sim_rig

RIG = sim_rig()
NAN, INF = float("nan"), float("inf")
IDENTITY = dict.fromkeys(
    ("clock_hz", "min_sample_period_ticks", "burst_sample_period_ticks"), 1
) | {"channel_count": 64}
DESCRIPTOR = {
    "scale": -1e14, "offset": -9e8, "filter_ns": 1, "filter2_ns": 1, "gain_uncertainty": 0.0,
    "offset_uncertainty": 9e8, "noise": 0.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, ""),
        ({"burst_sample_period_ticks": 0}, ""),
        ({"clock_hz": 0}, "clock_hz = 0"),
        ({"min_sample_period_ticks": 0}, "min_sample_period_ticks = 0"),
        ({"channel_count": 65}, "channel_count = 65"),
        (
            {"burst_sample_period_ticks": 2},
            "burst_sample_period_ticks = 2, above min_sample_period_ticks = 1",
        ),
    ],
)
def test_an_identity_that_no_board_can_mean(wrong: dict[str, int], said: str) -> None:
    assert wrong_identity(IDENTITY | wrong) == said


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({}, ""),
        ({"scale": 0.99e-15}, "scale = 9.9e-16"),
        ({"scale": 1.01e-15}, ""),
        ({"scale": -1.01e15}, "scale = -1010000000000000.0"),
        ({"scale": NAN}, "scale = nan"),
        ({"offset": -1e9}, "offset = -1000000000.0"),
        ({"offset": NAN}, "offset = nan"),
        ({"filter_ns": 0}, "filter2_ns = 1 and filter_ns = 0, which rings for ever"),
        ({"filter_ns": 0, "filter2_ns": 0}, ""),
        ({"gain_uncertainty": -0.1}, "gain_uncertainty = -0.1"),
        ({"offset_uncertainty": 1e9}, "offset_uncertainty = 1000000000.0"),
        ({"noise": NAN}, "noise = nan"),
        ({"step_uncertainty": -1}, "step_uncertainty = -1"),
        ({"step_uncertainty": 3.0}, ""),
    ],
)
def test_a_descriptor_that_no_channel_can_have(wrong: dict[str, float], said: str) -> None:
    assert wrong_descriptor(DESCRIPTOR | wrong) == said


@pytest.mark.parametrize(
    ("zero", "said"),
    [
        ({"current_offset": -9e8, "current_noise": 0.0}, ""),
        ({"current_offset": 1e9}, "current_offset = 1000000000.0"),
        ({"current_offset": NAN}, "current_offset = nan"),
        ({"current_offset": 1.0, "voltage_noise": -1e-9}, "voltage_noise = -1e-09"),
        ({"voltage_noise": INF}, "voltage_noise = inf"),
    ],
)
def test_a_zero_that_no_reading_at_rest_can_be(zero: dict[str, float], said: str) -> None:
    assert wrong_zero(zero) == said


# -- what a board guards
def test_features_are_bits() -> None:
    for one in Feature:
        assert has({"features": 1 << one}, one)
        assert not has({"features": ~(1 << one) & 0xFF}, one)
        assert one.name.lower() not in lacking({"features": 1 << one})
        assert len(lacking({"features": 1 << one})) == len(Feature) - 1
    assert lacking({}) == [one.name.lower() for one in Feature]


NEW: dict[str, Any] = {
    "board": "bench", "features": 0xFF, "inputs": 0b11, "protocol_major": 1, "protocol_minor": 3,
}  # fmt: skip


def limited(supply_v: float | None = None, per_turn: float = 4000.0, **limits: Any) -> Any:
    wiring = replace(RIG.wiring, counts_per_turn=per_turn)
    limits = {"current_a": 2.0, "supply_min_v": 6.0, "sign_check_s": 0.05} | limits
    made = replace(RIG.limits, **limits)
    return replace(RIG, limits=made, wiring=wiring, supply_voltage_v=supply_v)


def fact(kind: ChannelKind, scale: float = 0.01, noise: float = 1.0) -> dict[str, Any]:
    return {"kind": kind, "scale": scale, "noise": noise, "offset_uncertainty": 2.0}


def test_the_sign_check_is_of_a_quarter_of_the_limits_and_an_eighth_of_a_turn() -> None:
    known = {"current": fact(ChannelKind.INSTANT), "terminal_voltage": fact(ChannelKind.MEAN)}
    assert signs(limited(8.0), NEW, known) == {
        "sign_check_ms": 50,
        "sign_check_ma": 500,
        "sign_check_mv": 2000,
        "sign_check_counts": 500,
    }
    assert signs(limited(None), NEW, known)["sign_check_mv"] == 1500  # of the least supply


def test_what_noise_and_offset_may_show_counts_against_no_sign() -> None:
    rough = fact(ChannelKind.MEAN, -0.1, 3.0)  # six times .1 of 3 + 2 counts
    found = signs(limited(8.0), NEW, {"current": rough, "terminal_voltage": rough})
    assert (found["sign_check_ma"], found["sign_check_mv"]) == (3000, 3000)


def test_instants_of_a_switching_terminal_have_either_sign() -> None:
    known = {"terminal_voltage": fact(ChannelKind.INSTANT)}
    assert signs(limited(8.0), NEW, known)["sign_check_mv"] == 2**32 - 1


@pytest.mark.parametrize(
    ("per_turn", "counts"), [(16.0, 8), (64.0, 8), (80.0, 10), (1e6, 2**16 - 1)]
)
def test_play_and_a_detent_count_against_no_sign(per_turn: float, counts: int) -> None:
    assert signs(limited(per_turn=per_turn), NEW, {})["sign_check_counts"] == counts


@pytest.mark.parametrize(("seconds", "ms"), [(1e-4, 1), (0.0034, 3), (70.0, 2**16 - 1)])
def test_the_time_of_a_sign_check(seconds: float, ms: int) -> None:
    assert signs(limited(sign_check_s=seconds), NEW, {})["sign_check_ms"] == ms


def test_a_tiny_limit_is_one_unit_at_least() -> None:
    known = {
        "current": fact(ChannelKind.MEAN, 1e-9),
        "terminal_voltage": fact(ChannelKind.MEAN, 1e-9),
    }
    found = signs(limited(1e-5, current_a=1e-5), NEW, known)
    assert (found["sign_check_ma"], found["sign_check_mv"]) == (1, 1)


def test_rig_or_board_may_do_without_a_sign_check() -> None:
    assert signs(limited(sign_check_s=0.0), NEW, {}) == {}
    assert signs(limited(), NEW | {"features": 0xFF & ~(1 << Feature.SIGN_CHECK)}, {}) == {}


@pytest.mark.parametrize(("volts", "mv"), [(9.0004, 9000), (1e7, 2**32 - 1)])
def test_a_voltage_limit_in_the_board_s_integers(volts: float, mv: int) -> None:
    known = {"terminal_voltage": fact(ChannelKind.MEAN)}
    assert guards(limited(voltage_v=volts), NEW, known) == {"voltage_limit_mv": mv}


def test_contacts_are_bits() -> None:
    rig = limited(voltage_v=None, inputs=("part_present", "guard_closed"))
    assert guards(rig, NEW, {}) == {"inputs_required": 0b11}
    with pytest.raises(RigError, match="names part_present"):
        guards(rig, NEW | {"inputs": 0b10}, {})
    assert guards(limited(voltage_v=None, inputs=()), NEW, {}) == {}


@pytest.mark.parametrize(
    ("least", "level", "said"),
    [
        (4000, 4000, ""),
        (4000, 2700, "of bench resets it below 2.7 V, and its clock needs 4 V"),
        (2700, 0, "of bench is off, and its clock needs 2.7 V"),
    ],
)
def test_a_processor_that_may_run_on_too_little(least: int, level: int, said: str) -> None:
    found = brown_out({"board": "bench", "brown_out_least_mv": least, "brown_out_mv": level})
    assert said in found
    assert bool(said) == bool(found)
    assert brown_out({"board": "bench"}) == ""


# -- what a program puts on a motor
STEPS = (
    Step(StepKind.COAST, 1.0),
    Step(StepKind.BRAKE, 2.0),
    Step(StepKind.DRIVE_VOLTS, 0.5, -3.0, Decay.DIODE),
    Step(StepKind.DRIVE_DUTY, 0.25, 0.5, Decay.DIODE),
)


@pytest.mark.parametrize(
    ("read_v", "stated_v", "volts"), [(8.0, 10.0, 4.0), (None, 10.0, 5.0), (None, None, 6.0)]
)
def test_the_volts_of_each_driven_step(
    read_v: float | None, stated_v: float | None, volts: float
) -> None:
    rig = limited(stated_v, supply_max_v=12.0)
    assert program_volts(rig, Program(STEPS), read_v) == pytest.approx([3.0, volts])


def test_the_heat_of_a_rotor_that_stands() -> None:
    # 9 V² for .5 s and 16 V² for .25 s
    assert heat_j(Program(STEPS), [None, 0.0, -3.0, 4.0], 2.5) == pytest.approx(8.5 / 2.5)


@pytest.mark.parametrize(
    ("counts_per_s", "good"), [(95e3, True), (-95e3, True), (96e3, False), (-96e3, False)]
)
def test_a_speed_beyond_one_and_a_half_times_what_the_voltage_allows(
    counts_per_s: float, good: bool
) -> None:
    # 1.5 times 2 V over .02 V s: 150 rad/s of the motor, at 4000 counts for each turn behind 1:1
    rig = replace(limited(), nameplate=Nameplate(torque_constant_nm_a=0.02))
    pulse = Pulse(0.2, -2.0, 99, None, 0.0, 0.0, False, None, counts_per_s=counts_per_s)
    if good:
        judge_scale(rig, pulse)
    else:
        with pytest.raises(RigError, match=r"says 151 rad/s at 2 V, 1\.5 times what nameplate"):
            judge_scale(rig, pulse)
    judge_scale(rig, replace(pulse, volts=0.0))
    geared = replace(rig, wiring=replace(rig.wiring, gear_ratio=0.5))
    judge_scale(geared, pulse)


# -- a journal's header
GOOD: dict[str, list[Any]] = {
    "note": ["", "é"],
    "samples": [0, 2**53 - 1],
    "ambient_c": [None, 0, -1e299, 20.5],
    "wiring": [{}, {"gear_ratio": 1.0, "brush_drop_v": None}],
    "program": [{"steps": [{"level": 1.0, "on": True}, None, "x"]}],
    "calibration": [{"current": {"gain": 1.0, "nonlinearity_shape": "s", "offset": None}}],
    "voltage_sense": ["terminals", "supply"],
    "wire_steps": [[], [0, 5]],
    "supply_before_v": [0, 11.5],
    "measure": [True, False],
    "of_a_later_version": [object()],
}
BAD: dict[str, list[Any]] = {
    "note": [None, 5, "\ud800", "x" * (2**24 + 1)],
    "samples": [-1, 2**53, 1.0, True, None],
    "ambient_c": ["20", 1e300, True, NAN],
    "wiring": [[], None, {"gear_ratio": "1"}, {5: 1.0}],
    "program": [
        {"steps": [{"level": object()}]},
        {"steps": [{1: 2}]},
        [1],
        {"a": {"b": 1, "c": object()}},
        {"steps": [1, object()]},
        {"a": 1, "b": object()},
    ],
    "calibration": [{"current": 5}, {"current": {"gain": "round"}}],
    "voltage_sense": ["motor", None, 1],
    "wire_steps": [[-1], [0, -1], 5, [True], "12"],
    "supply_before_v": [None, "11"],
    "measure": [1, None],
}


@pytest.mark.parametrize("key", GOOD)
def test_what_a_header_may_hold(key: str) -> None:
    for value in GOOD[key]:
        check_kinds({key: value}, "the header")


@pytest.mark.parametrize("key", BAD)
def test_what_a_damaged_header_holds(key: str) -> None:
    for value in BAD[key]:
        with pytest.raises(DataError, match=rf"^the header is damaged: {key} cannot be"):
            check_kinds({"note": "ok", key: value}, "the header")


@pytest.mark.parametrize(
    ("length", "shown"), [(58, "'" + 58 * "x" + "'"), (59, "'" + 59 * "x" + "...")]
)
def test_a_long_value_is_shown_by_its_beginning(length: int, shown: str) -> None:
    with pytest.raises(DataError) as error:
        check_kinds({"measure": "x" * length}, "it")
    assert str(error.value) == f"it is damaged: measure cannot be {shown}"
