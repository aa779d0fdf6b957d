"""Decisions at their very bounds, and what a verdict then says."""

from __future__ import annotations

import math

import pytest
from scipy.stats import norm

from motorid.errors import EXIT_DATA, EXIT_DONE, EXIT_FAIL_VERDICT, UsageError
from motorid.quality.guard_band import (
    Rule,
    Specific,
    accepts,
    conformance,
    guard_band,
    nonconformance,
    quantile,
    risks,
    specific,
)
from motorid.quality.limits import Limit
from motorid.quality.verdict import EXIT_OF, Measurement, Outcome, Reading, Verdict, decide

INF = math.inf


@pytest.mark.parametrize(
    ("value", "inside"), [(1.0, True), (2.0, True), (3.0, True), (0.99, False), (3.01, False)]
)
def test_without_uncertainty_limits_belong_to_what_conforms(value: float, inside: bool) -> None:
    assert conformance(value, 0.0, 1.0, 3.0) == float(inside)
    assert nonconformance(value, 0.0, 1.0, 3.0) == float(not inside)
    assert accepts(value, 0.0, 1.0, 3.0, Rule()) is inside
    assert accepts(value, 0.5, 1.0, 3.0, Rule("simple")) is inside


@pytest.mark.parametrize("value", [-1.0, 0.5, 1.0, 2.2, 3.0, 6.0])
@pytest.mark.parametrize("limits", [(1.0, 3.0), (-INF, 3.0), (1.0, INF)])
def test_conformance_by_the_normal_distribution(value: float, limits: tuple[float, float]) -> None:
    low, high = limits
    inside = norm.cdf(high, value, 0.7) - norm.cdf(low, value, 0.7)
    assert conformance(value, 0.7, low, high) == pytest.approx(inside, rel=1e-9)
    assert nonconformance(value, 0.7, low, high) == pytest.approx(1.0 - inside, abs=1e-12)


def test_bands_of_each_rule() -> None:
    assert guard_band(0.5, 0.0, 9.0, Rule("simple")) == 0.0
    assert guard_band(0.5, 0.0, 9.0, Rule(r=0.5, coverage_factor=3.0)) == 0.75
    assert guard_band(0.5, 0.0, 9.0, Rule()) == 1.0
    risk = Rule("specific_risk", consumer_risk=0.1)
    assert guard_band(0.5, 0.0, 9.0, risk) == pytest.approx(0.5 * norm.ppf(0.9))
    assert guard_band(0.5, 0.0, 9.0, Rule("specific_risk", consumer_risk=0.6)) == 0.0
    assert quantile(0.3) == pytest.approx(norm.ppf(0.3))


@pytest.mark.parametrize(
    ("value", "accepted"), [(1.0, True), (0.99, False), (8.0, True), (8.01, False)]
)
def test_a_value_on_its_guard_band_is_accepted(value: float, accepted: bool) -> None:
    assert accepts(value, 0.5, 0.0, 9.0, Rule()) is accepted


def test_a_specific_risk_on_its_bound_is_accepted() -> None:
    """A value on its only limit conforms in half of the cases."""
    assert accepts(1.0, 0.3, -INF, 1.0, Rule("specific_risk", consumer_risk=0.5))
    assert not accepts(1.0, 0.3, -INF, 1.0, Rule("specific_risk", consumer_risk=0.49))


@pytest.mark.parametrize("half", [{"process_mean": 1.0}, {"process_sd": 1.0}, {}])
def test_half_a_process_is_none(half: dict[str, float]) -> None:
    with pytest.raises(UsageError, match="process_mean and process_sd"):
        risks(0.1, 0.0, 1.0, Rule(**half), 0.0)  # type: ignore[arg-type]
    found = specific(0.5, 0.1, 0.0, 1.0, Rule(**half))  # type: ignore[arg-type]
    assert found == Specific(True, found.conformance, None, found.risk, None)


@pytest.mark.parametrize("target", [0.002, 0.008])
@pytest.mark.parametrize("limits", [(-1.0, 1.0), (-INF, 1.0), (-1.0, INF)])
def test_the_band_of_a_global_risk_leaves_just_that_risk(
    target: float, limits: tuple[float, float]
) -> None:
    rule = Rule("global_risk", consumer_risk=target, process_mean=0.2, process_sd=0.8)
    band = guard_band(0.3, *limits, rule)
    assert band > 0.0
    assert risks(0.3, *limits, rule, band)[0] == pytest.approx(target, rel=1e-6)
    assert risks(0.3, *limits, rule)[0] == pytest.approx(target, rel=1e-6)
    assert risks(0.3, *limits, rule, 0.99 * band)[0] > target


def test_limits_too_close_for_a_global_risk_leave_nothing() -> None:
    """No band of a tolerance of 2 keeps a risk of 1e-12: half of the tolerance, and none passes."""
    rule = Rule("global_risk", consumer_risk=1e-12, process_mean=0.0, process_sd=5.0)
    assert guard_band(3.0, -1.0, 1.0, rule) == pytest.approx(1.0)
    consumer, producer = risks(3.0, -1.0, 1.0, rule, 1.0)
    assert consumer == 0.0
    assert producer == pytest.approx(norm.cdf(0.2) - norm.cdf(-0.2))


def test_a_posterior_by_hand() -> None:
    """Process 2 ± 3, reading 7 ± 4: weight 9/25, mean 3.8, standard deviation 2.4."""
    rule = Rule("simple", process_mean=2.0, process_sd=3.0)
    found = specific(7.0, 4.0, 0.0, 8.0, rule)
    assert found.accepted
    beyond = norm.cdf(0.0, 3.8, 2.4) + norm.sf(8.0, 3.8, 2.4)
    assert found.risk_with_process == pytest.approx(beyond)
    assert found.with_process == pytest.approx(1.0 - beyond)
    assert found.risk == pytest.approx(norm.cdf(0.0, 7.0, 4.0) + norm.sf(8.0, 7.0, 4.0))
    rejected = specific(9.0, 4.0, 0.0, 8.0, rule)  # mean 4.52
    assert not rejected.accepted
    assert rejected.risk == rejected.conformance
    assert (
        rejected.risk_with_process
        == rejected.with_process
        == pytest.approx(norm.cdf(8.0, 4.52, 2.4) - norm.cdf(0.0, 4.52, 2.4))
    )


# ---- verdicts --------------------------------------------------------------------------------

LIMIT = Limit("R_25", "ohm", 2.0, 3.0, low_means="shorted turns", high_means="a bad joint")


@pytest.mark.parametrize(
    ("value", "outcome", "marginal", "said"),
    [
        (2.5, Outcome.PASS, False, ""),
        (2.2, Outcome.PASS, False, ""),
        (2.19, Outcome.FAIL, True, "too near its limit 2 ohm (MARGINAL): shorted turns"),
        (2.81, Outcome.FAIL, True, "too near its limit 3 ohm (MARGINAL): a bad joint"),
        (1.5, Outcome.FAIL, False, "too low (limit 2 ohm): shorted turns"),
        (3.25, Outcome.FAIL, False, "too high (limit 3 ohm): a bad joint"),
    ],
)
def test_what_is_decided_and_said(
    value: float, outcome: Outcome, marginal: bool, said: str
) -> None:
    reading = Reading("ohm", value, 0.1, note="seen")
    found = decide(LIMIT, reading, "R")
    reason = f"R {value:g} ohm is {said}: seen" if said else ""
    assert (found.outcome, found.marginal, found.reason) == (outcome, marginal, reason)
    assert found.guard_band == pytest.approx(0.2)
    inside = norm.cdf(3.0, value, 0.1) - norm.cdf(2.0, value, 0.1)
    assert found.conformance == pytest.approx(inside)
    assert (found.quantity, found.meaning, found.limit) == ("R_25", "R", LIMIT)
    assert found.reading is reading


def test_a_limit_of_one_side_and_without_a_unit() -> None:
    high = Limit("ripple_turn", "1", high=0.1)
    found = decide(high, Reading("1", 0.2, 0.01), "ripple")
    assert found.reason == "ripple 0.2 is too high (limit 0.1)"
    low = Limit("x", "1", low=0.1)
    assert decide(low, Reading("1", 0.11, 0.01), "x").reason == (
        "x 0.11 is too near its limit 0.1 (MARGINAL)"
    )
    assert decide(low, Reading("1", 0.1, 0.0), "x").outcome is Outcome.PASS


@pytest.mark.parametrize(
    "reading",
    [Reading("ohm"), Reading("ohm", 2.5), Reading("ohm", None, 0.1), Reading("ohm", 2.5, -0.1),
     Reading("ohm", 2.5, math.nan)],
)  # fmt: skip
def test_what_was_not_measured_is_invalid(reading: Reading) -> None:
    found = decide(LIMIT, reading, "R")
    assert (found.outcome, found.reason) == (Outcome.INVALID, "R: it was not measured")
    assert (found.marginal, found.guard_band, found.conformance) == (False, 0.0, None)
    said = decide(LIMIT, Reading("ohm", problem="the lead is off"), "R")
    assert said.reason == "R: the lead is off"


def test_a_condition_that_is_not_met_is_invalid() -> None:
    ambient = Limit("ambient", "°C", 18.0, 28.0, Rule("simple"), True)
    assert decide(ambient, Reading("°C", 28.0, 2.0), "ambient").outcome is Outcome.PASS
    assert decide(ambient, Reading("°C", 28.1, 2.0), "ambient").outcome is Outcome.INVALID


def test_outcomes_leave_by_their_own_codes() -> None:
    codes = [EXIT_OF[one] for one in (Outcome.PASS, Outcome.FAIL, Outcome.INVALID)]
    assert codes == [EXIT_DONE, EXIT_FAIL_VERDICT, EXIT_DATA]


def of(*outcomes: tuple[Outcome, bool, bool]) -> Verdict:
    """Of outcomes, each with whether it is a condition's, and whether it is marginal."""
    made = [
        Measurement(
            f"q{k}", "", Limit(f"q{k}", "1", condition=condition), Reading("1"), one, marginal,
            reason="" if one is Outcome.PASS else f"why {k}",
        )
        for k, (one, condition, marginal) in enumerate(outcomes)
    ]  # fmt: skip
    return Verdict("p", "s", tuple(made))


PASS, FAIL, INVALID = Outcome.PASS, Outcome.FAIL, Outcome.INVALID


@pytest.mark.parametrize(
    ("parts", "outcome", "marginal", "reasons"),
    [
        ((), INVALID, False, ()),
        (((PASS, False, False), (PASS, True, False)), PASS, False, ()),
        (((FAIL, False, True), (INVALID, True, False)), INVALID, False, ("why 1",)),
        (((FAIL, False, True), (FAIL, True, False)), INVALID, False, ()),
        (((FAIL, False, True), (INVALID, False, False)), FAIL, True, ("why 0",)),
        (((FAIL, False, True), (FAIL, False, False)), FAIL, False, ("why 0", "why 1")),
        (((INVALID, False, False), (INVALID, True, False)), INVALID, False, ("why 1", "why 0")),
        (((PASS, True, False), (INVALID, False, False)), INVALID, False, ("why 1",)),
    ],
)
def test_the_whole_follows_from_its_parts(
    parts: tuple[tuple[Outcome, bool, bool], ...],
    outcome: Outcome,
    marginal: bool,
    reasons: tuple[str, ...],
) -> None:
    found = of(*parts)
    assert (found.outcome, found.marginal, found.reasons) == (outcome, marginal, reasons)
    assert found.exit_code == EXIT_OF[outcome]


def test_a_measurement_is_found_by_its_name() -> None:
    found = of((PASS, False, False), (FAIL, False, False))
    assert found["q1"] is found.measurements[1]
    with pytest.raises(KeyError):
        found["q2"]
