"""Figures that are withheld or widened: names, units, bounds; R at 25 °C of a wider model."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.results.estimate import UNITS, Alternative, Parameter, Rise
from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty import intervals, reference_temperature
from motorid.motor.parameters import FIGURES, Motor
from tests.estimate.made_findings import RELATIVE, VALUES, findings


def standing(p: Parameter) -> tuple[Any, ...]:
    return p.name, p.unit, p.value, p.status


@pytest.mark.parametrize("name", ["R", "T0", "K"])
def test_a_parameter_that_is_withheld_keeps_its_name_and_unit(name: str) -> None:
    found = intervals.parameters(findings({**RELATIVE, name: 2.0}))
    lost = [name] if name != "K" else ["K", "B", "T0"]
    for one in lost:
        assert standing(found[one]) == (one, UNITS[one], None, Status.NOT_IDENTIFIABLE)
    assert standing(found["J"])[:2] == ("J", UNITS["J"])


def test_a_figure_that_is_withheld_keeps_its_name_and_unit() -> None:
    weak = intervals.derived(findings(), 0.1)["no_load_speed"]
    vague = intervals.derived(findings({**RELATIVE, "J": 0.6}), 12.0)["mechanical_time_constant"]
    for p, name in ((weak, "no_load_speed"), (vague, "mechanical_time_constant")):
        unit = FIGURES[name].unit
        assert standing(p) == (name, unit, None, Status.NOT_IDENTIFIABLE)


@pytest.mark.parametrize(("besides", "given"), [(0.0, True), (0.3, True), (0.6, False)])
def test_what_is_no_parameter_widens_a_figure(besides: float, given: bool) -> None:
    """K + 3 B of values .05 and 4e-5, known to .5 % and 10 %, beside something else."""
    found = findings(causes={"gain": {"K": 0.02}})

    def of(motor: Motor) -> float:
        return motor.K + 3.0 * motor.B

    value = VALUES["K"] + 3.0 * VALUES["B"]
    p = intervals.positive(found, "figure", "x", of, "note", 0.5, besides * value)
    assert (p.value is not None) is given
    if given:
        noise = math.hypot(RELATIVE["K"] * VALUES["K"], 3.0 * RELATIVE["B"] * VALUES["B"])
        assert p.value == pytest.approx(value)
        assert p.statistical == pytest.approx(math.hypot(noise, besides * value), rel=1e-4)
        assert p.instrument == pytest.approx(0.02 * VALUES["K"], rel=1e-4)
        assert p.total == pytest.approx(math.hypot(p.statistical or 0.0, p.instrument or 0.0))
        reach = math.exp(intervals.NORMAL_95 * (p.total or 0.0) / value)
        assert p.interval_95 == pytest.approx((value / reach, value * reach))
        assert (p.name, p.unit, p.note, p.status) == ("figure", "x", "note", Status.ESTIMATED)


def test_a_figure_that_is_endless_or_negative_does_not_exist() -> None:
    for value in (math.inf, math.nan, 0.0, -1.0):
        p = intervals.positive(findings(), "figure", "x", lambda _, v=value: v, "", 0.5)
        assert standing(p) == ("figure", "x", None, Status.NOT_IDENTIFIABLE)
        assert p.note == "it does not exist for this motor"


def test_a_few_runs_widen_the_likelihoods_own_ends_by_instruments_alone() -> None:
    """Student's factor of their share: of 4 degrees, 2.776 of the gain's .1 of L and .5 of B."""
    found = findings(causes={"gain": {"L": 0.1, "B": 0.5}}, freedom=4.0)
    ends = {"L": (2.5e-3, 4e-3), "B": (1e-5, 9e-5)}
    p = intervals.parameters(replace(found, profiles=ends))
    for name, low, high in (("L", 3e-3 / 2.5e-3, 4e-3 / 3e-3), ("B", 3e-5, 5e-5)):
        k = list(VALUES).index(name)
        _, instrument, freedom = found.propagate(np.eye(6)[k])
        extra = intervals.student(freedom) * instrument
        interval = p[name].interval_95
        assert interval is not None
        if name == "L":
            assert math.log(3e-3 / interval[0]) == pytest.approx(math.hypot(math.log(low), extra))
            assert math.log(interval[1] / 3e-3) == pytest.approx(math.hypot(math.log(high), extra))
        else:
            assert interval[1] - 4e-5 == pytest.approx(math.hypot(high, extra))
            assert interval[0] == 0.0


def test_friction_is_given_up_to_its_own_size_of_uncertainty() -> None:
    at = intervals.parameters(findings({**RELATIVE, "B": 0.999}))["B"]
    beyond = intervals.parameters(findings({**RELATIVE, "B": 1.001}))["B"]
    assert (at.status, beyond.status) == (Status.ESTIMATED, Status.NOT_IDENTIFIABLE)
    assert at.value == VALUES["B"]


def test_friction_at_its_bound_keeps_its_two_parts_apart() -> None:
    p = intervals.parameters(findings(bound=("B",), causes={"gain": {"B": 0.3}}))["B"]
    parts = RELATIVE["B"] * VALUES["B"], 0.3 * VALUES["B"]
    assert (p.statistical, p.instrument) == pytest.approx(parts)
    assert p.total == pytest.approx(math.hypot(*parts))
    assert p.interval_95 == pytest.approx((0.0, intervals.NORMAL_95 * math.hypot(*parts)))
    assert (p.value, p.status, p.unit) == (0.0, Status.AT_BOUND, UNITS["B"])


@pytest.mark.parametrize(("terms", "kelvin"), [(("drag",), 20.0), (("drag", "heating"), 0.0)])
def test_a_wider_model_that_knows_the_heating_is_as_warm_as_its_room(
    terms: tuple[str, ...], kelvin: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    rise = Rise(20.0, 5.0, 100.0, "by I²R")
    inputs: Any = [{"ambient_c": 30.0, "ambient_uncertainty_c": 1.0}]

    def at_25(parameters: Any, warmth: Any, coefficients: Any) -> Any:
        assert (parameters, coefficients) == ("parameters", "coefficients")
        return warmth, "shares"

    monkeypatch.setattr(reference_temperature, "at_25", at_25)
    parameters: Any = "parameters"
    better = Alternative("auto", terms, (), (), False, parameters, {}, 1.0, 1, 1, ())
    coefficients: Any = "coefficients"
    found: Any = reference_temperature._beside(better, inputs, rise, coefficients)
    assert found.terms == terms
    warmth = found.at_25
    assert warmth.winding == pytest.approx(5.0 + kelvin)
    assert warmth.rise_uncertainty == (5.0 if kelvin else 0.0)
    assert warmth.magnets == pytest.approx(5.0)
    assert reference_temperature._beside(None, inputs, rise, coefficients) is None
