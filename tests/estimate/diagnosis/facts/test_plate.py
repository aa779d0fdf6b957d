"""A nameplate's figures that the fit does not have get a sentence, and a cause where one fits."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.capture.model import Capture, Stated
from motorid.estimate.diagnosis.facts.plate import findings
from motorid.estimate.diagnosis.faults import scale_errors
from motorid.estimate.results.estimate import Parameter
from motorid.estimate.results.status import Status
from tests.estimate.diagnosis.facts.made_log import MOTOR, log
from tests.report import example

TOP = (24.0 - MOTOR["R"] * MOTOR["T0"] / MOTOR["K"]) / (
    MOTOR["K"] + MOTOR["R"] * MOTOR["B"] / MOTOR["K"]
)
PLATE = {
    "voltage_v": 24.0,
    "resistance_ohm": MOTOR["R"],
    "inductance_h": MOTOR["L"],
    "torque_constant_nm_a": MOTOR["K"],
    "inertia_kg_m2": MOTOR["J"],
    "no_load_current_a": (MOTOR["T0"] + MOTOR["B"] * TOP) / MOTOR["K"],
}


def parameters(**factors: float) -> dict[str, Parameter]:
    values = {n: v * factors.get(n, 1.0) for n, v in MOTOR.items()}
    return {
        n: Parameter(n, "", v, 0.0, 0.0, 0.01 * v, None, Status.ESTIMATED)
        for n, v in values.items()
    }


def said(plate: dict[str, float], **factors: float) -> list[str]:
    estimate = replace(example.estimate(), parameters=parameters(**factors), suspects=())
    capture: Capture = replace(log(), stated=Stated(nameplate=plate))
    return [f"{d.severity}: {d.message}" for d in findings([capture], estimate)]


def test_a_motor_as_its_label_says_gets_no_word() -> None:
    assert said(PLATE) == []
    assert said({}) == []


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"J": 3.0}, "J is 3 times the nameplate's: a load on the shaft"),
        ({"R": 1.15}, "R is 1.15 times the nameplate's"),
        ({"K": 0.8}, "a magnet that has lost strength"),
        ({"B": 4.0, "T0": 4.0}, "the no-load current is"),
    ],
)
def test_each_figure_gets_its_sentence(factors: dict[str, float], words: str) -> None:
    (one,) = said(PLATE, **factors)
    assert one.startswith("info: ")
    assert words in one


@pytest.mark.parametrize("turns", [0.5, 1.8])
def test_the_label_of_another_winding_is_named(turns: float) -> None:
    plate = dict(PLATE)
    for key, power in (("resistance_ohm", 2), ("inductance_h", 2), ("torque_constant_nm_a", 1),
                       ("no_load_current_a", -1)):  # fmt: skip
        plate[key] *= turns**power
    found = scale_errors.suspects(parameters(), scale_errors.read_nameplate(plate), 24.0)
    assert [s.code for s in found] == ["other_winding"]
    assert f"{1.0 / turns:.2g} times its turns" in found[0].evidence


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_wrong_scale_of_the_voltage_is_no_other_winding(factor: float) -> None:
    scaled = dict.fromkeys(("R", "L", "K", "B", "J", "T0"), factor)
    plate = scale_errors.read_nameplate(PLATE)
    found = scale_errors.suspects(parameters(**scaled), plate, 24.0)
    assert [s.code for s in found] == ["voltage_scale"]
    moves = found[0].moves
    stated = parameters(**{**scaled, "T0": 3.0 * factor})  # as of a fit with brushes
    (again,) = scale_errors.suspects(parameters(**scaled), plate, 24.0, True, stated)
    assert again.moves == pytest.approx({**moves, "T0": 3.0 * moves["T0"]})
