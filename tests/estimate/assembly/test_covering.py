"""By how much an interval grows to cover that of the better model, and to which side."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.estimate.assembly.covering import Covering, covering, excluded
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.results.estimate import Diagnostic, Estimate
from motorid.estimate.uncertainty.budget import FINDING
from tests.report.example import estimate, parameter


def plain() -> Estimate:
    """R = 2 ± 0.1."""
    one = parameter("R", "Ω", 2.0)
    r = replace(one, interval_95=(1.9, 2.1), total=0.05, statistical=0.05, instrument=0.0)
    return replace(
        estimate(), parameters={"R": r, "L": parameter("L", "H", 1e-3)}, combinations={},
        derived={}, budget={"R": {"noise": 0.05}},
    )  # fmt: skip


def beside(value: float | None, interval: tuple[float, float] | None) -> Any:
    other = replace(parameter("R", "Ω", 2.0), value=value, interval_95=interval)
    return SimpleNamespace(parameters={"R": other})


@pytest.mark.parametrize(
    ("value", "interval", "sides"),
    [
        (2.2, (2.15, 2.25), (0.0, 0.15)),
        (1.8, (1.7, 1.9), (0.2, 0.0)),
        (2.2, None, (0.0, 0.1)),
        (2.04, (1.5, 2.4), (0.4, 0.3)),  # the value stays, and is open
        (2.04, (1.86, 2.14), None),  # by less than half of the interval
        (2.06, (2.0, 2.12), (0.0, 1.001 * 0.05)),  # enough for a doubt
        (2.06, (2.0, 2.09), None),  # it is covered already
        (2.06, (2.0, 2.1), None),  # to the end
        (None, None, None),
    ],
)
def test_it_covers_the_better_models_and_no_more(
    value: float | None, interval: tuple[float, float] | None, sides: tuple[float, float] | None
) -> None:
    found = covering(plain(), beside(value, interval), ["R"])
    if sides is None:
        assert found == Covering()
        return
    assert found.sides == {"R": pytest.approx(sides)}
    assert found.moves == {"R": pytest.approx(max(sides))}


@pytest.mark.parametrize(
    ("value", "out"), [(2.101, True), (2.1, False), (1.9, False), (1.899, True), (None, False)]
)
def test_an_interval_excludes_a_value_beyond_its_ends(value: float | None, out: bool) -> None:
    better = beside(value, None)
    better.parameters["L"] = parameter("L", "H", 1e-3)
    assert excluded(plain(), better, ()) == (["R"] if out else [])
    assert excluded(plain(), better, ("R",)) == []
    none = replace(plain().parameters["R"], value=None, interval_95=None)
    one = replace(plain(), parameters={"R": none})
    assert excluded(one, better, ()) == []


def test_a_value_that_is_unknown_is_not_covered() -> None:
    none = replace(plain().parameters["R"], value=None, interval_95=None)
    one = replace(plain(), parameters={"R": none})
    assert covering(one, beside(2.2, (2.15, 2.25)), ["R"]) == Covering()


@pytest.mark.parametrize("before", [0.0, 0.3])
def test_the_interval_then_ends_with_the_better_models(before: float) -> None:
    """Whatever another finding has added to it before."""
    one = plain()
    if before:
        one = settled(one, [Diagnostic("lack_of_fit", "warning", "it lacks", {"R": before})])
    low, high = one.parameters["R"].interval_95 or (0.0, 0.0)
    better = beside(high + 0.5, (high + 0.3, high + 0.7))
    found = covering(one, better, ["R"])
    said = Diagnostic("better_model", "warning", "it is better", found.moves, found.sides)
    after = settled(one, [said])
    r = after.parameters["R"]
    assert r.interval_95 == pytest.approx((low, high + 0.7))
    assert r.total == pytest.approx(0.05 * (high + 0.7 - low) / 0.2)
    assert sum(u**2 for u in after.budget["R"].values()) == pytest.approx((r.total or 0.0) ** 2)
    assert after.budget["R"][FINDING + "better model"] > 0.0
