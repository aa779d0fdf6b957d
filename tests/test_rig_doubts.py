"""Nameplates with a figure in another unit are asked about; those of good rigs are not."""

from __future__ import annotations

import pytest

from bench.coverage.rigs import draw_bench
from motorid.rig import load_rig
from motorid.rig_file import parse, presets
from motorid.workflow.rig_doubts import doubts, nameplate_doubt


@pytest.mark.parametrize(
    ("right", "copied", "asked"),
    [
        ("torque_constant_nm_a = 7.68e-3", "torque_constant_nm_a = 7.68", "in mN·m/A"),
        ("torque_constant_nm_a = 7.68e-3", "torque_constant_nm_a = 0.804", "in V/krpm"),
        ("inertia_kg_m2 = 3.9e-7", "inertia_kg_m2 = 3.9", "inertia_kg_m2 in g·cm²"),
        ("resistance_ohm = 2.6", "resistance_ohm = 2600", "resistance_ohm in mohm"),
    ],
)
def test_a_figure_in_another_unit_is_asked_about(right: str, copied: str, asked: str) -> None:
    text = load_rig("sim").text
    assert f"\n{right}\n" in text
    (said,) = doubts(parse(text.replace(f"\n{right}\n", f"\n{copied}\n"), "bench.toml"))
    assert asked in said
    assert copied in said


@pytest.mark.parametrize("name", presets())
def test_the_rigs_that_come_with_it_are_not(name: str) -> None:
    assert nameplate_doubt(load_rig(name)) == ""


def test_nor_is_a_motor_of_many_amperes() -> None:
    """Of a model car: 65 mohm, as no precision motor has them."""
    text = load_rig("sim").text
    for right, other in (
        ("torque_constant_nm_a = 7.68e-3", "torque_constant_nm_a = 5e-3"),
        ("inertia_kg_m2 = 3.9e-7", "inertia_kg_m2 = 6e-6"),
        ("resistance_ohm = 2.6", "resistance_ohm = 0.065"),
        ("inductance_h = 180e-6", "inductance_h = 30e-6"),
    ):
        assert f"\n{right}\n" in text
        text = text.replace(f"\n{right}\n", f"\n{other}\n")
    assert nameplate_doubt(parse(text, "bench.toml")) == ""


@pytest.mark.slow
def test_nor_are_drawn_ones() -> None:
    assert [s for s in range(60) if nameplate_doubt(draw_bench(s).rigs[0])] == []
