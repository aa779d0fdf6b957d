"""Verdicts follow from their measurements, and from nothing else."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.estimate.assembly.doubt import settled
from motorid.estimate.assembly.refusal import refused
from motorid.estimate.model.unexplained import Unexplained
from motorid.estimate.results.estimate import Alternative, Diagnostic, Estimate, Suspect
from motorid.estimate.results.status import Status
from motorid.quality.guard_band import Rule
from motorid.quality.judge import judge, not_measured, not_running
from motorid.quality.limits import Limit
from motorid.quality.product import Product
from motorid.quality.quantities import QUANTITIES, Context
from motorid.quality.verdict import Measurement, Outcome, Reading, Verdict, decide, whole

R25, K25 = 2.6, 7.68e-3  # of the simulated motor


def measured(outcome: Outcome, *, condition: bool = False) -> Measurement:
    limit = Limit("x", "1", 0, 1, condition=condition)
    return Measurement("x", "x", limit, Reading("1", 0.5, 0.1), outcome)


def test_the_whole_follows_from_the_parts() -> None:
    ok, bad, unknown = (measured(o) for o in (Outcome.PASS, Outcome.FAIL, Outcome.INVALID))
    assert whole([ok, ok]) is Outcome.PASS
    assert whole([ok, bad, unknown]) is Outcome.FAIL  # one failure is enough to reject
    assert whole([ok, unknown]) is Outcome.INVALID
    assert whole([bad, measured(Outcome.INVALID, condition=True)]) is Outcome.INVALID
    assert whole([]) is Outcome.INVALID
    codes = [Verdict("p", "s", (m,)).exit_code for m in (ok, bad, unknown)]
    assert codes == [0, 1, 4]


def test_between_guard_band_and_limit_is_marginal() -> None:
    limit = Limit("R_25", "ohm", 2.4, 2.8)
    inside, edge, beyond = (
        decide(limit, Reading("ohm", v, 0.01), "resistance") for v in (2.77, 2.79, 2.81)
    )
    assert (inside.outcome, inside.marginal) == (Outcome.PASS, False)
    assert (edge.outcome, edge.marginal) == (Outcome.FAIL, True)
    assert (beyond.outcome, beyond.marginal) == (Outcome.FAIL, False)
    assert edge.guard_band == pytest.approx(0.02)
    assert "MARGINAL" in edge.reason
    assert "too high" in beyond.reason
    assert Verdict("p", "s", (inside, edge)).marginal
    assert not Verdict("p", "s", (edge, beyond)).marginal


@pytest.mark.parametrize(("value", "bound"), [(2.41, "2.4"), (2.79, "2.8")])
def test_a_marginal_motor_names_the_limit_that_it_is_near(value: float, bound: str) -> None:
    limit = Limit("R_25", "ohm", 2.4, 2.8, low_means="too few turns", high_means="a bad joint")
    found = decide(limit, Reading("ohm", value, 0.01), "resistance")
    means = "too few turns" if bound == "2.4" else "a bad joint"
    assert found.reason == (
        f"resistance {value:g} ohm is too near its limit {bound} ohm (MARGINAL): {means}"
    )


def test_what_was_not_measured_keeps_its_name_and_its_meaning() -> None:
    limit = Limit("R_25", "ohm", 2.4, 2.8)
    found = decide(limit, Reading("ohm", problem="give the ambient"), "resistance at 25 °C")
    assert found.outcome is Outcome.INVALID
    assert (found.quantity, found.meaning) == ("R_25", "resistance at 25 °C")
    assert found.reason == "resistance at 25 °C: give the ambient"


def test_a_good_motor_passes(estimate: Estimate, product: Product) -> None:
    verdict = judge(estimate, product)
    assert verdict.outcome is Outcome.PASS, verdict.reasons
    assert verdict.serial == "D000001"
    assert verdict.reasons == ()
    for name, true in (("R_25", R25), ("K_25", K25)):
        reading = verdict[name].reading
        assert reading.value is not None
        assert reading.uncertainty is not None
        assert abs(reading.value - true) < 3 * reading.uncertainty


def test_the_product_chooses_the_model_and_the_verdict_says_which(
    estimate: Estimate, product: Product
) -> None:
    R = estimate.parameters["R"]
    assert R.value is not None
    other = {**estimate.parameters, "R": replace(R, value=1.5 * R.value)}
    words = (("eddy",), ("eddy currents",), ("as it may be",))
    better = Alternative("six+eddy", *words, False, other, {}, 1.0, 1, 1, ())
    both, usual = replace(estimate, alternative=better), judge(estimate, product)
    chosen = judge(both, replace(product, model="better"))
    expected = 1.5 * (usual["R_25"].reading.value or 0.0)
    assert chosen["R_25"].reading.value == pytest.approx(expected)
    assert "six+eddy" in chosen["model"].meaning
    asked = replace(both, alternative=replace(better, asked=True))
    for verdict in (judge(both, product), judge(asked, replace(product, model="better"))):
        assert verdict["R_25"].reading == usual["R_25"].reading
        assert "model" not in {m.quantity for m in verdict.measurements}


def test_uncertainty_of_the_temperature_is_in_r_25(estimate: Estimate, product: Product) -> None:
    inputs = tuple({**i, "ambient_uncertainty_c": 5.0} for i in estimate.inputs)
    doubtful = judge(replace(estimate, inputs=inputs), product)["R_25"].reading
    assert doubtful.uncertainty == pytest.approx(R25 * 0.0039 * 5.0, rel=0.05)


def test_figures_are_those_of_the_cold_motor(estimate: Estimate, product: Product) -> None:
    inputs = tuple({**i, "ambient_c": 65.0, "ambient_uncertainty_c": 0.0} for i in estimate.inputs)
    context = Context(replace(estimate, inputs=inputs, brushes=None), product)
    hot = {name: float(p.value or 0.0) for name, p in estimate.parameters.items()}
    # 40 K cooler, copper conducts better and magnets are stronger
    K, R = hot["K"] / (1.0 - 0.0011 * 40.0), hot["R"] / (1.0 + 0.0039 * 40.0)
    volts = product.voltage_v
    found = {n: QUANTITIES[n].read(context).value for n in ("stall_torque", "no_load_speed")}
    assert found["stall_torque"] == pytest.approx(K * volts / R - hot["T0"], rel=1e-9)
    speed = (K * volts - R * hot["T0"]) / (K**2 + R * hot["B"])
    assert found["no_load_speed"] == pytest.approx(speed, rel=1e-9)


@pytest.mark.slow
def test_cold_and_hot_agree_at_25(measure: object, product: Product, estimate: Estimate) -> None:
    import motorid

    hot = motorid.fit(measure("ambient=40"))  # type: ignore[operator]
    inputs = tuple({**i, "ambient_c": 40.0} for i in hot.inputs)
    verdict = judge(replace(hot, inputs=inputs), product)
    first = judge(estimate, product)
    for name in ("R_25", "K_25"):
        a, b = verdict[name].reading, first[name].reading
        assert a.value == pytest.approx(b.value, rel=0.003)
    assert verdict.outcome is Outcome.INVALID  # the product's ambient ends at 28
    assert "ambient temperature" in verdict.reasons[0]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"end_reason": "fault: over_current"}, "ended early"),
        ({"gaps": 3}, "lost 3 samples"),
        ({"serial": "XYZ"}, "scan the label again"),
        ({"ambient_c": None}, "conditions.ambient_c"),
    ],
)
def test_bad_conditions_are_invalid(
    estimate: Estimate, product: Product, change: dict[str, object], says: str
) -> None:
    inputs = tuple({**i, **change} for i in estimate.inputs)
    verdict = judge(replace(estimate, inputs=inputs), product)
    assert verdict.outcome is Outcome.INVALID
    assert any(says in reason for reason in verdict.reasons)


def test_a_fit_that_did_not_settle_is_invalid(estimate: Estimate, product: Product) -> None:
    unsettled = replace(estimate, diagnostics=(Diagnostic("x", "error", "it did not settle"),))
    assert judge(unsettled, product).outcome is Outcome.INVALID


def test_what_is_not_identifiable_is_invalid(estimate: Estimate, product: Product) -> None:
    unknown = replace(
        estimate.parameters["T0"], value=None, total=None, status=Status.NOT_IDENTIFIABLE,
        note="a coast-down would determine it",
    )  # fmt: skip
    verdict = judge(replace(estimate, parameters={**estimate.parameters, "T0": unknown}), product)
    assert verdict["T0"].outcome is Outcome.INVALID
    assert "coast-down" in verdict["T0"].reason
    assert verdict.outcome is Outcome.INVALID


def test_a_wider_guard_band_makes_the_same_motor_marginal(
    estimate: Estimate, product: Product
) -> None:
    strict = replace(product.limits["R_25"], rule=Rule("uncertainty", r=8.0))
    verdict = judge(estimate, replace(product, limits={"R_25": strict}))
    assert verdict.outcome is Outcome.FAIL
    assert verdict.marginal


def test_not_measured_says_why(product: Product) -> None:
    verdict = not_measured(product, "D000001", "the cable is out")
    assert (verdict.outcome, verdict.reasons) == (Outcome.INVALID, ("the cable is out",))


def test_a_motor_that_does_not_run_fails_and_is_no_marginal_one(product: Product) -> None:
    dead = not_running(product, "D000001", "open winding", "no current at 6 V")
    assert (dead.outcome, dead.marginal) == (Outcome.FAIL, False)
    unsound = not_running(product, "D000001", "open winding", "no current at 6 V", "no self-test")
    assert (unsound.outcome, unsound.marginal) == (Outcome.INVALID, False)


@pytest.mark.parametrize(("name", "resting"), [("R", "ripple_segment"), ("K", "unbalance")])
def test_what_rests_on_a_doubtful_parameter_is_invalid(
    name: str, resting: str, estimate: Estimate, product: Product
) -> None:
    value = estimate.parameters[name].value
    lag = Suspect("current_lag", "current", "it is late", "declare it", "named", {name: value or 0})
    verdict = judge(settled(estimate, [lag]), product)
    for quantity in (f"{name}_25", resting):
        assert verdict[quantity].outcome is Outcome.INVALID
        assert "current lag" in verdict[quantity].reason
    assert verdict.outcome is Outcome.INVALID


def test_without_supported_parameters_nothing_is_judged(
    estimate: Estimate, product: Product
) -> None:
    worst = Unexplained("current", 0.9, 0.9, declared=False)
    verdict = judge(refused(estimate, worst), product)
    assert verdict.outcome is Outcome.INVALID
    assert "no motor gives these readings" in verdict.reasons[0]
