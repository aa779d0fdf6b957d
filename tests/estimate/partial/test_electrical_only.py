"""Captures with voltage and current alone: what they tell, and what they leave open."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.capture.model import POSITION, VOLTAGE, Capture
from motorid.errors import DataError, UsageError
from motorid.estimate.partial import electrical_only
from motorid.estimate.results.estimate import Estimate, Parameter
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

K = FAULHABER["K"]
TRUE = {
    **FAULHABER,
    "J/K²": FAULHABER["J"] / K**2,
    "B/K²": FAULHABER["B"] / K**2,
    "T0/K": FAULHABER["T0"] / K,
}
PLAN = Plan(volts=(3.0, 6.0, 4.0), count=4000)


@cache
def clean(friction_nm: float) -> Capture:
    return clean_capture({**FAULHABER, "T0": friction_nm}, PLAN)


def seen(seed: int, friction_nm: float = FAULHABER["T0"]) -> Capture:
    return noisy(clean(friction_nm), seed, 5e-3, 1e-3, 5e-3)


def motionless(seed: int, friction_nm: float = FAULHABER["T0"]) -> Capture:
    """A noisy capture whose position is thrown away."""
    return without_motion(seen(seed, friction_nm))


def without_motion(capture: Capture) -> Capture:
    channels = {name: c for name, c in capture.channels.items() if name != POSITION}
    return replace(capture, channels=channels)


def missed(estimate: Estimate, names: tuple[str, ...]) -> list[str]:
    """Which of these are not known, or off by more than three standard deviations."""
    found = {**estimate.parameters, **estimate.combinations}
    told = {n: (found[n].value, found[n].total) for n in names}
    return [n for n, (v, u) in told.items() if v is None or not abs(v - TRUE[n]) <= 3.0 * u]


@pytest.mark.slow
def test_all_but_the_scale_of_its_constant_is_told() -> None:
    estimate = fit([motionless(4)])
    assert missed(estimate, ("R", "L", "J/K²", "B/K²", "T0/K")) == []
    for name in ("R", "L", "J/K²"):
        p = {**estimate.parameters, **estimate.combinations}[name]
        assert p.total < 0.02 * p.value
    for name in ("K", "B", "J", "T0"):
        assert estimate.parameters[name].status == "not_identifiable"
        assert "add the speed or the position" in estimate.parameters[name].note
    (said,) = (d.message for d in estimate.diagnostics if d.code == "budget")
    for name in ("R", "L", "J/K²", "B/K²", "T0/K"):
        assert f"{name} (" in said
    assert not any(f" {name} (" in said for name in ("K", "B", "J", "T0"))
    assert set(estimate.derived) == {
        "stall_current", "electrical_time_constant", "mechanical_time_constant", "peak_efficiency",
    }  # fmt: skip
    (said,) = (d.message for d in estimate.diagnostics if d.code == "no_motion")
    assert "To determine K, B, J and T0 as well" in said


@pytest.mark.slow
def test_a_fit_that_begins_at_its_answer_knows_the_brushes_drop() -> None:
    """Derivatives from before a model's current was followed, when nothing was lost, must go."""
    drop = fit([motionless(3)]).nuisance["brush drop"]
    assert drop.total < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("name", ["K", "J", "T0"])
def test_one_that_is_given_tells_the_others(name: str) -> None:
    estimate = fit([motionless(5)], fix={name: FAULHABER[name]})
    others = tuple(n for n in FAULHABER if n != name)
    assert missed(estimate, others) == []
    assert estimate.parameters["K"].value == pytest.approx(K, rel=0.02)


@pytest.mark.slow
def test_two_that_are_given_are_refused() -> None:
    with pytest.raises(UsageError, match="K and J together"):
        fit([motionless(4)], fix={"K": K, "J": 4e-7})


@pytest.mark.slow
def test_without_the_back_emf_of_a_coast_the_drive_tells() -> None:
    """A voltage that is commanded says nothing while the bridge is open."""
    capture = motionless(6)
    volts = capture.channels[VOLTAGE]
    commanded = replace(volts, sense="command")
    estimate = fit([replace(capture, channels={**capture.channels, VOLTAGE: commanded})])
    assert missed(estimate, ("R", "L", "J/K²", "T0/K")) == []


@pytest.mark.slow
def test_a_rotor_that_is_held_tells_resistance_and_inductance_alone() -> None:
    estimate = fit([motionless(7, friction_nm=1.0)])
    assert missed(estimate, ("R", "L")) == []
    assert not estimate.combinations
    for name in ("K", "B", "J", "T0"):
        assert estimate.parameters[name].status == "not_identifiable"
        assert "nothing shows that the rotor turned" in estimate.parameters[name].note
    assert set(estimate.derived) == {"stall_current", "electrical_time_constant"}


@pytest.mark.slow
def test_a_capture_without_motion_joins_one_with() -> None:
    estimate = fit([seen(9), motionless(6)])
    assert missed(estimate, tuple(FAULHABER)) == []


@pytest.mark.slow
def test_nothing_of_the_motion_is_told_where_the_resistance_is_not() -> None:
    """The speed is seen through R: whatever a fit says of friction then is worth nothing."""
    found = fit([motionless(4)])
    vague = {**found.parameters, "R": electrical_only.unknown("R", "ohm", "")}
    told = electrical_only._open(replace(found, parameters={**vague, **_of_scale_one(found)}))
    assert {p.status for p in told.combinations.values()} == {"not_identifiable"}


def _of_scale_one(found: Estimate) -> dict[str, Parameter]:
    """J, B and T0 as of K = 1."""
    return {name: found.combinations[ratio] for name, (ratio, _) in electrical_only.RATIOS.items()}


@pytest.mark.parametrize("name", ["K", "B", "J", "T0"])
@pytest.mark.parametrize("true", [0.02, 3.0])
def test_one_that_is_given_sets_the_scale_of_all(
    name: str, true: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a motor with K = k: v = R i + k ω and J dω/dt = k i - ... in x = k ω has K = 1, J/k², B/k²
    and T0/k, and the same R and L."""
    motor = {"R": 2.0, "L": 1e-3, "K": true, "B": 4e-5, "J": 2e-5, "T0": 6e-3}
    by = {"K": true, "B": true**2, "J": true**2, "T0": true}
    scaleless = {n: value / by.get(n, 1.0) for n, value in motor.items()}
    begun: list[dict[str, float]] = []
    monkeypatch.setattr(electrical_only, "MotorRecord", lambda *given: given)
    monkeypatch.setattr(
        electrical_only.multistart, "solve", lambda _records, _free, start: begun.append(start)
    )
    none: Any = SimpleNamespace(own=())
    electrical_only._on_scale([], none, {name: motor[name]}, (), name, scaleless)
    assert begun == [pytest.approx(motor)]
    with pytest.raises(DataError, match=f"--fix {name} sets no scale"):
        electrical_only._on_scale([], none, {name: 1.0}, (), name, {**scaleless, name: 0.0})
