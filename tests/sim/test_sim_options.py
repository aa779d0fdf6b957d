"""sim:// URLs: what they may say, and one clear sentence for what they may not."""

from __future__ import annotations

import pytest

from motorid.acquire.ports import serial_of
from motorid.errors import UsageError
from motorid.sim import truth
from motorid.sim.chain import draw_chain
from motorid.sim.motor import motors
from motorid.sim.options import parse_url
from motorid.sim.port import RealTimePort, SimPort, open_sim


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("sim://?moter=maxon-re35", "'motor'"),
        ("sim://?motor=maxon-re36", "maxon-re35"),
        ("sim://?motor=maxon", "maxon-re35"),
        ("sim://?noise=loud", "noise must be a number"),
        ("sim://?noise=nan", "between 0 and 1000"),
        ("sim://?seed=1.5", "whole number"),
        ("sim://?bits=40", "between 8 and 15"),
        ("sim://?speed=warp", "realtime, max"),
        ("sim://?heating=maybe", "0 or 1"),
        ("sim://?seed=1&seed=2", "twice"),
        ("sim://?fault=flp", "'flip'"),
        ("sim://?fault=flip:2", "between 0 and 1"),
        ("sim://?fault=reset:3", "no value"),
        ("sim://?fault=reset@soon", "not a number"),
        ("sim://?pwm=17000", "divide"),
        ("sim://?decay_modes=slow", "decay mode"),
        ("sim://faulhaber", "question mark"),
        ("sim://?supply_limit=2&supply_capacitance=0", "supply_capacitance"),
        ("file://x", "sim://"),
    ],
)
def test_an_absurd_url_is_one_sentence(url: str, says: str) -> None:
    with pytest.raises(UsageError) as caught:
        open_sim(url)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_beginning_of_a_motor_name_is_enough() -> None:
    assert parse_url("sim://?motor=faulhaber").preset is motors()["faulhaber-2338s006s"]


def test_speed_chooses_the_clock() -> None:
    assert type(open_sim("sim://?speed=max")) is SimPort
    assert type(open_sim("sim://")) is RealTimePort


@pytest.mark.parametrize("name", motors())
def test_presets_are_motors(name: str) -> None:
    motor = motors()[name]
    no_load = motor.coulomb_nm + motor.viscous_nm_s * motor.voltage_v / motor.torque_constant_nm_a
    assert 0.001 < no_load / motor.torque_constant_nm_a / motor.stall_current_a < 0.1
    tau_m = motor.resistance_ohm * motor.inertia_kg_m2 / motor.torque_constant_nm_a**2
    assert 1e-3 < tau_m < 0.1
    assert motor.inductance_h / motor.resistance_ohm < tau_m
    assert motor.source
    assert motor.friction


def test_truth_is_as_run() -> None:
    facts = truth("sim://?ambient=35&load_inertia=1e-6&gain_error=0.01&clock_ppm=7")
    assert facts["R"] == pytest.approx(2.6 * 1.039)
    assert facts["K"] < facts["K_25"] == 7.68e-3
    assert facts["J"] == pytest.approx(1.39e-6)
    assert facts["chain"]["current"]["gain_error"] == pytest.approx(0.01)
    assert facts["chain"]["clock_ppm"] == 7


def test_a_board_keeps_its_errors_whatever_the_noise() -> None:
    own, again, other = (truth(f"sim://?seed={s}&board=7")["chain"] for s in (7, 1, 2))
    assert own == truth("sim://?seed=7")["chain"] == again == other
    assert truth("sim://?seed=1")["chain"] != own
    assert serial_of("sim://?seed=1&board=7") == serial_of("sim://?seed=7") == "sim-7"
    lies = {draw_chain(parse_url(f"sim://?seed={s}&board=7")).encoder_angle for s in (1, 2)}
    assert len(lies) == 2
