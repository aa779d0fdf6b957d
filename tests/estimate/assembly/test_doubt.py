"""What findings do to the values that they could have moved."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from motorid.estimate.assembly.doubt import doubtful, grown, settled
from motorid.estimate.results.estimate import Diagnostic, Estimate, Parameter, Suspect
from motorid.estimate.results.status import Status
from motorid.motor.parameters import FIGURES, Motor
from tests.report.example import estimate as example
from tests.report.example import parameter


def suspect(code: str = "current_lag", **moves: float) -> Suspect:
    return Suspect(code, "current", "it comes late", "declare it", "named", moves)


@pytest.fixture
def estimate() -> Estimate:
    found = example()
    budget = {n: {"noise": p.total} for n, p in found.parameters.items() if p.total}
    motor = Motor.of({name: p.value for name, p in found.parameters.items()})
    derived = {
        name: parameter(name, FIGURES[name].unit, FIGURES[name].of(motor, 6.0))
        for name in ("Kv", "stall_current", "mechanical_time_constant")
    }
    return replace(found, budget=budget, derived=derived, nominal_v=6.0)


def half(p: Parameter) -> float:
    assert p.interval_95 is not None
    return (p.interval_95[1] - p.interval_95[0]) / 2.0


def top(p: Parameter) -> float:
    assert p.interval_95 is not None
    return p.interval_95[1]


def u(p: Parameter) -> float:
    assert p.total is not None
    return p.total


@pytest.mark.parametrize(("share", "expected"), [(0.4, "estimated"), (0.6, "doubtful")])
def test_half_of_the_half_width_is_the_limit(
    share: float, expected: str, estimate: Estimate
) -> None:
    move = share * half(estimate.parameters["R"])
    assert settled(estimate, [suspect(R=move)]).parameters["R"].status == expected


def test_the_interval_covers_the_old_one_moved_and_no_more(estimate: Estimate) -> None:
    before = estimate.parameters["R"]
    move = 3.0 * half(before)
    after = settled(estimate, [suspect(R=move)]).parameters["R"]
    assert before.interval_95 is not None
    assert after.interval_95 == pytest.approx(
        (before.interval_95[0] - move, before.interval_95[1] + move)
    )
    assert after.value == before.value
    assert half(after) / u(after) == pytest.approx(half(before) / u(before))
    assert "current lag" in after.note


def test_a_move_whose_way_is_known_counts_on_that_side_alone(estimate: Estimate) -> None:
    before = estimate.parameters["R"]
    assert before.interval_95 is not None
    wide = 2.0 * half(before)
    said = Diagnostic("better_model", "warning", "so", {"R": wide}, {"R": (0.5 * wide, wide)})
    both = suspect(R=wide)
    low, high = before.interval_95
    alone = settled(estimate, [said]).parameters["R"]
    assert alone.interval_95 == pytest.approx((low - 0.5 * wide, high + wide))
    assert u(alone) / half(alone) == pytest.approx(u(before) / half(before))
    beside = settled(estimate, [said, both]).parameters["R"].interval_95
    assert beside == pytest.approx((low - math.hypot(0.5, 1.0) * wide, high + math.sqrt(2) * wide))


def test_parts_and_budget_sum_to_the_total(estimate: Estimate) -> None:
    R = estimate.parameters["R"]
    found = settled(estimate, [suspect(R=2.0 * half(R)), suspect("supply", R=half(R))])
    after, lines = found.parameters["R"], found.budget["R"]
    assert after.statistical == R.statistical
    assert math.hypot(after.statistical or 0.0, after.instrument or 0.0) == pytest.approx(u(after))
    assert sum(line**2 for line in lines.values()) == pytest.approx(u(after) ** 2, rel=1e-9)
    assert lines["finding: current lag"] == pytest.approx(2.0 * lines["finding: supply"])
    assert found.budget["K"] == estimate.budget["K"]


def test_a_small_finding_counts_beside_a_large_one(estimate: Estimate) -> None:
    """What moves a value by less than half of its interval matters with one that moves it more."""
    R = estimate.parameters["R"]
    large, small = 2.0 * half(R), 0.4 * half(R)
    found = settled(estimate, [suspect(R=large), suspect("supply", R=small)])
    after = found.parameters["R"]
    assert half(after) - half(R) == pytest.approx(math.hypot(large, small))
    lines = found.budget["R"]
    assert lines["finding: current lag"] == pytest.approx(5.0 * lines["finding: supply"])
    assert "supply" not in after.note


def test_what_has_no_interval_was_not_widened() -> None:
    none = Parameter("L", "H", None, None, None, None, None, Status.NOT_IDENTIFIABLE)
    assert grown(none, {"finding: x": 1.0}) == 0.0
    sure = Parameter("K", "", 2.0, 0.0, 0.0, 0.0, (1.9, 2.1), Status.ESTIMATED)
    assert grown(sure, {"finding: x": 1.0}) == 0.0
    widened = replace(sure, total=0.05)
    assert grown(widened, {"noise": 0.03, "finding: x": 0.04}) == pytest.approx(0.1 * (1 - 0.6))
    assert grown(widened, {"noise": 0.05}) == 0.0


def test_a_named_fault_without_moves_changes_nothing(estimate: Estimate) -> None:
    assert settled(estimate, [suspect()]) is estimate
    tiny = settled(estimate, [suspect(R=1e-9)])
    assert tiny.parameters == estimate.parameters
    assert tiny.budget == estimate.budget


def test_what_is_fixed_or_unknown_stays_so(estimate: Estimate) -> None:
    K = Parameter("K", "N·m/A", 0.05, 0.0, 0.0, 0.0, (0.05, 0.05), Status.FIXED)
    L = Parameter("L", "H", None, None, None, None, None, Status.NOT_IDENTIFIABLE)
    given = replace(estimate, parameters={**estimate.parameters, "K": K, "L": L})
    found = settled(given, [suspect(K=1.0, L=1.0)])
    assert (found.parameters["K"], found.parameters["L"]) == (K, L)


def test_a_positive_value_stays_positive(estimate: Estimate) -> None:
    J = estimate.parameters["J"]
    after = settled(estimate, [suspect(J=5.0 * (J.value or 0.0))]).parameters["J"]
    assert after.interval_95 is not None
    assert after.interval_95[0] == 0.0


def test_a_move_without_a_size_takes_what_is_allowed_at_most_the_value(
    estimate: Estimate,
) -> None:
    R = estimate.parameters["R"]
    assert R.value is not None
    endless = Diagnostic("lack_of_fit", "warning", "it lacks something", {"R": math.inf})
    some = 5.0 * half(R)
    for allowed, move in (({"R": some}, some), ({"R": 9e9}, R.value), ({}, R.value)):
        after = settled(estimate, [endless], allowed).parameters["R"]
        assert after.status is Status.DOUBTFUL
        assert top(after) == pytest.approx(top(R) + move)


def test_figures_follow_their_parameters(estimate: Estimate) -> None:
    K = estimate.parameters["K"]
    assert K.value is not None
    found = settled(estimate, [suspect(K=0.5 * K.value)])
    assert half(found.derived["Kv"]) > 0.3 * 30.0 / math.pi / K.value
    statuses = {name: p.status for name, p in found.derived.items()}
    assert statuses == {
        "Kv": Status.DOUBTFUL,
        "mechanical_time_constant": Status.DOUBTFUL,
        "stall_current": Status.ESTIMATED,
    }
    assert [p.name for p in doubtful(found)] == ["K", "J/K"]


def test_an_inductance_at_another_frequency_moves_as_it_does_at_none(estimate: Estimate) -> None:
    L = estimate.parameters["L"]
    assert L.value is not None
    assert L.interval_95 is not None
    low, high = L.interval_95
    metered = replace(
        L, name="L_1kHz", value=L.value / 2, total=u(L) / 2, interval_95=(low / 2, high / 2)
    )
    wider = replace(estimate, parameters={**estimate.parameters, "L_1kHz": metered})
    move = 3.0 * half(L)
    finding = Diagnostic("model_unsettled", "warning", "", {"L": move}, {"L": (0.0, move)})
    after = settled(wider, [finding]).parameters
    assert after["L_1kHz"].status == Status.DOUBTFUL
    assert after["L_1kHz"].interval_95 == pytest.approx(
        [end / 2 for end in after["L"].interval_95 or ()]
    )
    assert after["K"] == estimate.parameters["K"]
