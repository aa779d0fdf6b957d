"""Intervals and standings: from a covariance and causes made by hand, against the textbook."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from motorid.estimate.results.status import Status
from motorid.estimate.uncertainty import intervals
from motorid.estimate.uncertainty.intervals import student
from motorid.motor.parameters import FIGURES, Motor
from tests.estimate.made_findings import LOG, RELATIVE, VALUES, findings

VOLTS = 12.0


@pytest.mark.parametrize("freedom", [1.0, 2.0, 3.0, 5.0, 6.0, 6.5, 7.3, 12.0, 25.5, 300.0, 1e5])
def test_students_factor(freedom: float) -> None:
    assert student(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=1e-3)


@pytest.mark.parametrize("freedom", [1.1, 1.4, 1.7, 2.4, 3.5, 4.7, 5.9])
def test_students_factor_between_the_exact_ones(freedom: float) -> None:
    assert student(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=5e-3)


@pytest.mark.parametrize("freedom", [6.0, 7.0, 8.0, 12.0, 20.0, 50.0])
def test_the_series_lacks_its_sixth_term_alone(freedom: float) -> None:
    off = student(freedom) / stats.t.ppf(0.975, freedom) - 1.0
    assert abs(off) < 0.4 / freedom**5


@pytest.mark.parametrize("freedom", [1.0, 1.25, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0 - 1e-9])
def test_the_table_is_exact_where_it_has_an_entry(freedom: float) -> None:
    assert student(freedom) == pytest.approx(stats.t.ppf(0.975, freedom), rel=2e-6)


def test_students_factor_has_ends() -> None:
    assert student(0.2) == student(1.0)
    assert student(np.inf) == student(1e9) == pytest.approx(stats.norm.ppf(0.975), rel=1e-12)


@pytest.mark.parametrize("name", LOG)
def test_an_error_of_a_positive_parameter_is_a_factor(name: str) -> None:
    p = intervals.parameters(findings(causes={"gain": {name: 0.02}, "clock": {name: 0.01}}))[name]
    total = math.sqrt(RELATIVE[name] ** 2 + 0.02**2 + 0.01**2)
    value = VALUES[name]
    assert p.status is Status.ESTIMATED
    assert p.value == value
    assert p.statistical == pytest.approx(RELATIVE[name] * value)
    assert p.instrument == pytest.approx(math.hypot(0.02, 0.01) * value)
    assert p.total == pytest.approx(total * value)
    reach = math.exp(intervals.NORMAL_95 * total)
    assert p.interval_95 == pytest.approx((value / reach, value * reach))


@pytest.mark.parametrize("name", ["B", "T0"])
def test_an_error_of_friction_is_a_sum(name: str) -> None:
    p = intervals.parameters(findings(causes={"gain": {name: 0.02}}))[name]
    total = math.hypot(RELATIVE[name], 0.02) * VALUES[name]
    assert p.total == pytest.approx(total)
    half = intervals.NORMAL_95 * total
    assert p.interval_95 == pytest.approx((VALUES[name] - half, VALUES[name] + half))


def test_friction_that_may_be_none_has_no_negative_end() -> None:
    p = intervals.parameters(findings({**RELATIVE, "B": 0.8}))["B"]
    assert p.status is Status.ESTIMATED
    assert p.interval_95 is not None
    assert p.interval_95[0] == 0.0
    assert p.interval_95[1] == pytest.approx(VALUES["B"] * (1 + 0.8 * intervals.NORMAL_95))


@pytest.mark.parametrize(("name", "known", "lost"), [("R", 0.49, 0.51), ("T0", 0.98, 1.02)])
def test_what_is_too_uncertain_is_not_given(name: str, known: float, lost: float) -> None:
    def standing(relative: float) -> Status:
        return intervals.parameters(findings({**RELATIVE, name: relative}))[name].status

    assert standing(known) is Status.ESTIMATED
    assert standing(lost) is Status.NOT_IDENTIFIABLE


def test_what_is_not_given_says_its_bound_and_the_remedy() -> None:
    p = intervals.parameters(findings({**RELATIVE, "T0": 2.0}))["T0"]
    assert (p.value, p.total, p.interval_95) == (None, None, None)
    most = VALUES["T0"] * (1 + 2.0 * intervals.NORMAL_95)
    assert f"below {most:.2g} N·m" in p.note
    assert intervals.REMEDY["T0"] in p.note


def test_instruments_count_too_where_a_value_is_withheld() -> None:
    assert intervals.parameters(findings(causes={"gain": {"R": 0.6}}))["R"].value is None


def test_at_the_bound_friction_has_an_upper_end_and_the_rest_nothing() -> None:
    found = intervals.parameters(findings(bound=("B",)))
    assert found["B"].status is Status.AT_BOUND
    assert found["B"].value == 0.0
    half = intervals.NORMAL_95 * RELATIVE["B"] * VALUES["B"]
    assert found["B"].interval_95 == pytest.approx((0.0, half))
    assert found["R"].status is Status.ESTIMATED


def test_without_the_torque_constant_no_torque_has_a_scale() -> None:
    found = intervals.parameters(findings({**RELATIVE, "K": 0.6}))
    assert {n for n, p in found.items() if p.value is None} == {"K", "B", "T0"}
    assert "no torque is known without K" in found["B"].note


def test_what_was_given_is_no_finding() -> None:
    found = intervals.parameters(findings(fixed={"K": 0.07}, without=("B",)))
    for name, value in (("K", 0.07), ("B", 0.0)):
        p = found[name]
        assert (p.status, p.value, p.total, p.interval_95) == (
            Status.FIXED, value, 0.0, (value, value),
        )  # fmt: skip
    assert list(found) == list(VALUES)


def test_the_ends_of_a_likelihood_take_the_place_of_its_curvature() -> None:
    ends = {"L": (2.5e-3, 4e-3), "B": (1e-5, 9e-5)}
    of_noise = intervals.parameters(replace(findings(), profiles=ends))
    assert of_noise["L"].interval_95 == pytest.approx(ends["L"])
    assert of_noise["B"].interval_95 == pytest.approx(ends["B"])
    causes = {"gain": {"L": 0.1, "B": 0.5}}
    wider = intervals.parameters(replace(findings(causes=causes), profiles=ends))
    z = intervals.NORMAL_95
    low = math.hypot(math.log(3e-3 / 2.5e-3), z * 0.1)
    assert wider["L"].interval_95 is not None
    assert wider["L"].interval_95[0] == pytest.approx(3e-3 * math.exp(-low))
    assert wider["B"].interval_95 is not None
    assert wider["B"].interval_95[1] == pytest.approx(4e-5 + math.hypot(5e-5, z * 0.5 * 4e-5))


@pytest.mark.parametrize(
    ("reach", "status"),
    [((0.9, 1.05), Status.ESTIMATED), ((0.9, 1.07), Status.NOT_IDENTIFIABLE),
     ((0.1, 1.8), Status.ESTIMATED), ((0.1, 1.9), Status.NOT_IDENTIFIABLE)],
)  # fmt: skip
def test_ends_that_lie_a_factor_of_seven_apart_tell_nothing(
    reach: tuple[float, float], status: Status
) -> None:
    """The same bound as the curvature's: half of the width, over 1.96, at most 50 %."""
    down, up = (math.exp(x) for x in reach)
    ends = {"L": (3e-3 / down, 3e-3 * up)}
    found = intervals.parameters(replace(findings(), profiles=ends))["L"]
    assert found.status is status


def test_few_runs_widen_and_instruments_that_are_known_less() -> None:
    """Welch and Satterthwaite, GUM G.4.1: freedom times the square of total over statistical."""
    found = findings(freedom=4.0, causes={"gain": {"R": 0.01}})
    _, _, freedom = found.propagate(np.eye(6)[0])
    assert freedom == pytest.approx(4.0 * (1.0 + 1.0) ** 2)
    _, _, alone = found.propagate(np.eye(6)[2])
    assert alone == pytest.approx(4.0)
    _, _, both = findings(freedom=4.0).propagate(np.array([1.0, 0.25, 0, 0, 0, 0]))
    assert both == pytest.approx(8.0)  # two that are equal: their freedoms add up
    assert findings().propagate(np.eye(6)[0])[2] == np.inf


@pytest.mark.parametrize("name", list(FIGURES))
def test_a_figure_follows_the_motor(name: str) -> None:
    found = findings(correlation={("R", "K"): 0.4})
    p = intervals.derived(found, VOLTS)[name]

    def of(**values: float) -> float:
        return FIGURES[name].of(Motor.of({**VALUES, **values}), VOLTS)

    step = 1e-5
    gradient = np.array(
        [
            (of(**{n: v * (1 + step)}) - of(**{n: v * (1 - step)})) / (2 * step)
            for n, v in VALUES.items()
        ]
    )  # for relative changes
    relative = np.array(list(RELATIVE.values()))
    correlation = np.eye(6)
    correlation[0, 2] = correlation[2, 0] = 0.4
    u = math.sqrt((gradient * relative) @ correlation @ (gradient * relative))
    assert p.value == pytest.approx(of())
    assert p.total == pytest.approx(u, rel=1e-3)
    assert p.interval_95 is not None
    assert p.interval_95[1] == pytest.approx(
        of() * math.exp(intervals.NORMAL_95 * u / of()), rel=1e-3
    )


def test_a_figure_says_its_voltage_where_it_has_one() -> None:
    found = intervals.derived(findings(), VOLTS)
    said = {name for name, p in found.items() if p.note.endswith("at 12 V")}
    assert said >= {"no_load_speed", "stall_current", "stall_torque", "peak_efficiency"}
    assert not said & {"Kv", "mechanical_time_constant", "electrical_time_constant"}


def test_a_motor_without_inductance_has_no_electrical_time_constant() -> None:
    assert "electrical_time_constant" not in intervals.derived(findings(without=("L",)), VOLTS)


def test_a_figure_that_does_not_exist_or_is_not_known() -> None:
    weak = intervals.derived(findings(), 0.1)["no_load_speed"]  # friction holds the motor
    assert (weak.status, weak.value) == (Status.NOT_IDENTIFIABLE, None)
    assert "does not exist" in weak.note
    vague = intervals.derived(findings({**RELATIVE, "J": 0.6}), VOLTS)["mechanical_time_constant"]
    assert vague.value is None
    assert "not known well enough" in vague.note


def test_ratios_are_printed_where_a_parameter_of_theirs_is_lost() -> None:
    lost = findings({**RELATIVE, "K": 0.6, "J": 0.6}, correlation={("K", "J"): 0.9999})
    given = intervals.parameters(lost)
    found = intervals.combinations(lost, given)
    assert "J/K" in found
    assert (found["J/K"].name, found["J/K"].unit) == ("J/K", "kg·m²·A/(N·m)")
    assert found["J/K"].value == pytest.approx(VALUES["J"] / VALUES["K"])
    assert found["J/K"].total == pytest.approx(
        0.6 * math.sqrt(2 - 2 * 0.9999) * VALUES["J"] / VALUES["K"], rel=1e-3
    )
    assert "L/R" not in found  # both are known by themselves
    assert "B/K" not in found  # as uncertain as K


def test_no_ratio_where_all_is_known() -> None:
    found = findings()
    assert intervals.combinations(found, intervals.parameters(found)) == {}


def test_lines_of_a_budget_sum_to_the_total() -> None:
    found = findings(causes={"gain": {"R": 0.02, "B": 0.3}, "clock": {"B": -0.1}})
    shares, given = intervals.budget_shares(found), intervals.parameters(found)
    assert set(shares["B"]) == {"noise", "gain", "clock"}
    assert set(shares["K"]) == {"noise"}
    for name, lines in shares.items():
        assert math.sqrt(sum(u**2 for u in lines.values())) == pytest.approx(given[name].total)
    assert shares["B"]["clock"] == pytest.approx(0.1 * VALUES["B"])


def test_a_ratio_of_errors_that_are_factors() -> None:
    p = intervals.of_ratio("x", "1", 4.0, 0.3, 0.4, np.inf)
    assert p.total == pytest.approx(0.5)
    reach = math.exp(intervals.NORMAL_95 * 0.5 / 4.0)
    assert p.interval_95 == pytest.approx((4.0 / reach, 4.0 * reach))


@pytest.mark.parametrize("name", intervals.RATIOS)
def test_a_ratio_is_what_its_name_says(name: str) -> None:
    known = {"R": 2.0, "L": 3.0, "K": 5.0, "J": 7.0, "B": 11.0, "T0": 13.0}
    written = name.replace("²", "**2").replace("J R", "J*R")
    by_name = eval(written, {"__builtins__": {}}, known)
    powers = intervals.RATIOS[name][1]
    assert math.prod(known[n] ** power for n, power in powers.items()) == pytest.approx(by_name)


def test_a_ratio_keeps_its_two_parts_apart() -> None:
    found = intervals.of_ratio("L/R", "s", 2.0, 0.03, 0.04, np.inf)
    assert (found.name, found.unit, found.value, found.status) == (
        "L/R",
        "s",
        2.0,
        Status.ESTIMATED,
    )
    assert (found.statistical, found.instrument) == (0.03, 0.04)
    assert found.total == pytest.approx(0.05)
    assert found.interval_95 is not None
    low, high = found.interval_95
    assert low * high == pytest.approx(4.0)
    assert math.log(high / 2.0) == pytest.approx(1.96 * 0.025, rel=1e-3)
