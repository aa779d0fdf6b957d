"""What a weak pulse's figures say of the motor, its sensors and its wires; each by made figures."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import check
from motorid.acquire.held_rotor import TravelWatch, allowed_counts
from motorid.acquire.pulse import Pulse
from motorid.acquire.signs import Sign, SignError
from motorid.capture.model import CURRENT
from motorid.errors import RigError
from motorid.rig import Nameplate
from motorid.wire.enums import ChannelKind
from tests.acquire.rigs import sim_rig

RIG = replace(sim_rig(), nameplate=Nameplate(resistance_ohm=2.0))
PER_TURN = RIG.wiring.counts_per_turn
STILL = Pulse(0.2, 1.4, 0, 0.7, 0.01, 0.8, False, 1.4)  # by 2 ohm


def of(**facts: Any) -> Pulse:
    return replace(STILL, **facts)


def why(pulse: Pulse | None, rig: Any = RIG) -> tuple[str, Sign | None]:
    error = check._why_still(rig, pulse)
    return str(error), error.sign if isinstance(error, SignError) else None


# -- sensors, whether or not the motor moved
@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ({"voltage_v": -0.43}, r"reads -0\.43 V while \+1\.40 V drives: swap the two sense wires"),
        ({"voltage_v": -0.41}, r"reads -0\.41 V while 1\.40 V should drive: check the bridge"),
        ({"voltage_v": 0.41}, "should drive"),
        ({"voltage_v": 0.43}, None),
        ({"voltage_v": None}, None),
        ({"saturated": True}, r"at an end of its range at 20% duty: the motor is shorted"),
    ],
)
def test_what_sensors_cannot_show(facts: dict[str, Any], says: str | None) -> None:
    rig = replace(RIG, voltage_sense="terminals")
    if says is None:
        check.judge_sensors(rig, of(**facts))
    else:
        with pytest.raises(RigError, match=says):
            check.judge_sensors(rig, of(**facts))


def test_a_bridge_that_drops_volts_should_drive_less() -> None:
    rig = replace(RIG, wiring=replace(RIG.wiring, bridge_drop_v=0.4), voltage_sense="terminals")
    check.judge_sensors(rig, of(voltage_v=0.31))  # of 1.0 V
    with pytest.raises(RigError, match="should drive"):
        check.judge_sensors(rig, of(voltage_v=0.29))
    check.judge_sensors(replace(rig, voltage_sense="supply"), of(voltage_v=-5.0))


@pytest.mark.parametrize(
    ("fact", "means"),
    [
        (None, True),
        ({"aperture_ns": 100_000, "kind": ChannelKind.MEAN}, True),  # 2 periods of 20 kHz
        ({"aperture_ns": 100_000, "kind": ChannelKind.INSTANT}, False),
        ({"aperture_ns": 100_090, "kind": ChannelKind.MEAN}, True),
        ({"aperture_ns": 100_110, "kind": ChannelKind.MEAN}, False),
        ({"aperture_ns": 99_890, "kind": ChannelKind.MEAN}, False),
        ({"aperture_ns": 75_000, "kind": ChannelKind.MEAN}, False),
        ({"aperture_ns": 0, "kind": ChannelKind.MEAN}, False),
    ],
)
def test_a_mean_is_of_whole_pwm_periods(fact: Any, means: bool) -> None:
    known = {} if fact is None else {CURRENT: fact}
    board: Any = SimpleNamespace(descriptors=known, identity={"pwm_hz": 20_000})
    assert check.reads_means(board) is means


@pytest.mark.parametrize(("noise", "clear"), [(0.139, True), (0.141, False)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_current_is_clear_beyond_five_times_its_noise(
    noise: float, clear: bool, sign: float
) -> None:
    assert of(current_a=0.7 * sign, current_noise_a=noise).draws is clear


def test_a_current_of_five_times_its_noise_is_not_clear() -> None:
    assert not of(current_a=0.5, current_noise_a=0.1).draws


def test_no_sensor_draws_nothing() -> None:
    assert not of(current_a=None).draws


@pytest.mark.parametrize(
    ("current_a", "brakes"), [(-0.7, True), (None, True), (0.04, False), (-0.04, False)]
)
def test_a_braked_motor_drives_its_current_back(current_a: float | None, brakes: bool) -> None:
    assert check._brakes(of(current_a=current_a)) is brakes


def test_a_current_the_wrong_way_is_a_reversed_sensor() -> None:
    with pytest.raises(RigError, match=r"reads 0\.7 A while the motor is braked from a positive"):
        check._brakes(of(current_a=0.7))
    with pytest.raises(RigError, match=r"reads -0\.7 A under positive voltage: the sensor is rev"):
        check._judge_current(of(current_a=-0.7))
    with pytest.raises(RigError, match=r"turns at 20% duty, but the current sensor reads 0\.04 A"):
        check._judge_current(of(current_a=0.04))
    check._judge_current(of(current_a=0.7))
    check._judge_current(of(current_a=None))


# -- a motor that did not turn
@pytest.mark.parametrize(
    ("share", "swings"), [(-0.08, True), (-0.09, False), (0.08, False), (0.0, False)]
)
def test_a_rotor_that_falls_back_by_less_than_a_twelfth_of_a_turn_swings(
    share: float, swings: bool
) -> None:
    assert check._swings(RIG, of(counts=round(share * PER_TURN))) is swings


def test_a_count_against_the_drive_is_backwards() -> None:
    with pytest.raises(RigError, match=r"counts backwards \(-9 counts\).*encoder_reversed = true"):
        check._judge_encoder(RIG, of(counts=-9))
    with pytest.raises(RigError, match="encoder_reversed = false"):
        check._judge_encoder(replace(RIG, encoder_reversed=True), of(counts=-9))
    check._judge_encoder(RIG, of(counts=9))
    check._judge_encoder(RIG, of(counts=0))


@pytest.mark.parametrize(
    ("facts", "says", "sign"),
    [
        ({"counts": -4}, "the rotor swings by -4 counts at 20% duty (1.40 V)", Sign.SWINGS),
        ({"counts": 3, "current_a": 0.04}, "and draws nothing", Sign.OPEN),
        ({"coast_v": 0.13}, "no voltage of a turning motor: free the shaft", Sign.SEIZED),
        ({"coast_v": -0.13}, "no voltage of a turning motor: free the shaft", Sign.SEIZED),
        ({"coast_v": 0.15}, "free the shaft, or check the encoder's wires", None),
        ({"coast_v": 0.41}, "free the shaft, or check the encoder's wires", None),
        ({"coast_v": 0.43}, "show 0.43 V of a turning motor: check the", None),
        ({"coast_v": -0.43}, "free the shaft, or check the encoder's wires", None),
        ({"coast_v": None}, "free the shaft, or check the encoder's wires", None),
        ({"coast_v": 0.0, "current_a": 0.24}, "free the shaft", Sign.SEIZED),  # 2.9 times 2 ohm
        ({"coast_v": 0.0, "current_a": 0.23}, "and draws 0.23 A", Sign.OPEN),  # 3.04 times
        ({"coast_v": None, "current_a": 0.1}, "though the motor draws 0.1 A", None),
    ],
)
def test_why_a_motor_does_not_turn(facts: dict[str, Any], says: str, sign: Sign | None) -> None:
    text, found = why(of(**facts))
    assert says in text
    assert found is sign


def test_without_a_nameplate_no_circuit_is_another_one() -> None:
    rig = replace(RIG, nameplate=Nameplate())
    text, sign = why(of(coast_v=0.0, current_a=0.1), rig)
    assert sign is Sign.SEIZED
    assert "draws 0.1 A" in text


def test_no_pulse_weak_enough() -> None:
    assert why(None)[0].startswith("no pulse is weak enough for limits.current_a")


def test_a_bound_of_the_resistance_takes_the_peak() -> None:
    assert check._bound(of(peak_a=0.8)) == pytest.approx(1.4 / 0.8 / 1.5)
    assert check._bound(of(peak_a=0.0)) is None
    assert check._bound(of(current_a=None)) is None


# -- the supply and the zero
@pytest.mark.parametrize(
    ("read_v", "stated_v", "found"),
    [(None, 9.0, 9.0), (None, None, 12.0), (6.0, 9.0, 6.0), (12.0, 9.0, 12.0), (7.5, None, 7.5)],
)
def test_the_supply_that_a_check_goes_by(
    read_v: float | None, stated_v: float | None, found: float
) -> None:
    limits = replace(RIG.limits, supply_min_v=6.0, supply_max_v=12.0)
    rig = replace(RIG, limits=limits, supply_voltage_v=stated_v)
    board: Any = SimpleNamespace(supply_v=lambda: read_v)
    assert check.check_supply(board, rig) == found


@pytest.mark.parametrize(
    ("read_v", "says"),
    [
        (5.99, r"reads 5\.99 V, below limits\.supply_min_v = 6: is it connected"),
        (12.01, r"reads 12\.01 V, above limits\.supply_max_v = 12: turn it down"),
    ],
)
def test_a_supply_beyond_its_limits(read_v: float, says: str) -> None:
    rig = replace(RIG, limits=replace(RIG.limits, supply_min_v=6.0, supply_max_v=12.0))
    board: Any = SimpleNamespace(supply_v=lambda: read_v)
    with pytest.raises(RigError, match=says):
        check.check_supply(board, rig)


@pytest.mark.parametrize(("offset", "good"), [(10, False), (11, True), (99, True), (100, False)])
def test_a_zero_at_an_end_of_the_range(offset: float, good: bool) -> None:
    facts: Any = {CURRENT: {"raw_min": 10, "raw_max": 100}}
    if good:
        check.check_zero({"current_offset": offset}, facts)
    else:
        with pytest.raises(RigError, match=f"reads {offset} counts with the bridge open"):
            check.check_zero({"current_offset": offset}, facts)
    check.check_zero({"current_offset": offset}, {})


# -- a rotor that is held
@pytest.mark.parametrize(
    ("per_turn", "counts"), [(400.0, 3), (1199.0, 3), (2000.0, 5), (8192.0, 20)]
)
def test_what_a_clamp_may_give_way(per_turn: float, counts: int) -> None:
    assert (
        allowed_counts(replace(RIG, wiring=replace(RIG.wiring, counts_per_turn=per_turn))) == counts
    )


@pytest.mark.parametrize("began", [0, 1000, 2**32 - 3])
@pytest.mark.parametrize("way", [1, -1])
def test_a_rotor_that_creeps_by_twice_that_is_stopped(began: int, way: int) -> None:
    rig = replace(RIG, wiring=replace(RIG.wiring, counts_per_turn=2000.0))
    watch = TravelWatch(rig, SimpleNamespace(requested=False))

    def sees(counts: int) -> bool:
        block: Any = SimpleNamespace(position=(began + counts) % 2**32)
        watch.consume(block)
        return watch.requested

    assert not sees(0)
    assert not sees(10 * way)
    watch.insist()
    assert sees(11 * way)
    assert sees(0)  # once moved is moved
    with pytest.raises(RigError, match=rf"crept by {11 * way} counts"):
        watch.insist()
    assert TravelWatch(rig, SimpleNamespace(requested=True)).requested
