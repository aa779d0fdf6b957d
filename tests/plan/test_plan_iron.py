"""A plan for the iron: a PRBS that the rig takes, within its heat, whose promise a run keeps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.acquire.safety import check_program
from motorid.cli.main import run
from motorid.errors import RigError, UsageError
from motorid.plan import iron
from motorid.program import Program, Rotor
from motorid.rig import Rig, load_rig
from motorid.rig_file import find, parse
from motorid.workflow.plan_iron import asks_for_iron, plan_iron, rig_text


def bench(options: str = "") -> Rig:
    rig = load_rig("sim-re35")
    return replace(rig, port=f"{rig.port}&speed=max{options}")


def clamped(program: Program) -> Program:
    return replace(program, rotor=Rotor.CLAMPED)


@pytest.mark.slow
def test_it_is_a_program_that_the_rig_takes_and_its_file_reads_back(tmp_path: Path) -> None:
    rig = bench()
    plan = plan_iron(rig, ["L_1kHz=3%"], energy_j=8.0)
    assert plan.program.rotor is Rotor.ASK
    assert plan.heat_j <= 8.0
    check_program(rig, clamped(plan.program), resistance_ohm=1.2 / 1.3)
    target = tmp_path / "iron.toml"
    read = parse(rig_text(rig, find("sim-re35"), plan, target), str(target))
    assert read.program == plan.program
    assert [p.want.name for p in plan.promises] == ["L_1kHz"]
    assert all(p.met for p in plan.promises)


@pytest.mark.slow
def test_a_board_of_few_steps_gets_a_signal_that_it_holds() -> None:
    few = plan_iron(bench("&max_steps=16"), ["L_1kHz=30%"])
    assert len(few.program.steps) <= 16
    long = plan_iron(bench("&max_steps=5"), ["L_1kHz=30%"])
    assert len(long.program.steps) == 5  # a rest, and two bits twice
    with pytest.raises(RigError, match="no PRBS for a held rotor fits this board"):
        plan_iron(bench("&max_steps=4"), ["L_1kHz=30%"])


def test_chips_are_long_enough_for_a_line_of_the_source() -> None:
    for seconds in iron.SECONDS:
        bits = [n for n in iron.BITS if seconds / 2 / (2**n - 1) >= iron.LINE * 1e-4]
        assert max(bits) >= 3  # at 10 kHz


@pytest.mark.parametrize(
    ("wants", "message"),
    [
        (["K=1%"], "K, B, J and T0 need a rotor that turns"),
        (["L_1kHz=3"], "is NAME=NUMBER%"),
        (["L=0%"], "is NAME=NUMBER%"),
    ],
)
def test_wants_that_such_a_run_cannot_meet(wants: list[str], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        plan_iron(bench(), wants)


def test_what_the_rig_must_state() -> None:
    rig = bench()
    with pytest.raises(RigError, match=r"L_rated needs nameplate\.rated_current_a"):
        plan_iron(rig, ["L_rated=3%"])
    with pytest.raises(RigError, match="nameplate lacks resistance_ohm"):
        plan_iron(replace(rig, nameplate=replace(rig.nameplate, resistance_ohm=None)), [])
    with pytest.raises(RigError, match=r"lacks wiring\.supply_voltage_v"):
        plan_iron(replace(rig, supply_voltage_v=None), [])


def test_a_want_of_the_iron_needs_no_flag_and_products_do_not_go_with_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert asks_for_iron(["R=1%", "L_pwm=5%"])
    assert not asks_for_iron(["R=1%", "L=5%"])
    line = ["plan", "--rig", "sim-line", "--product", "sim-disc", "--want", "L_1kHz=3%"]
    assert run(line) == 2
    assert "--product and --capture do not go with" in capsys.readouterr().err
    assert run(["plan", "--rig", "sim", "--energy", "3"]) == 2
    assert "--energy goes with --iron" in capsys.readouterr().err
