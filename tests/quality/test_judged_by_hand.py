"""Conditions of a verdict, each met and not met, of an estimate made by hand; and stored ones."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scipy.stats import norm

from motorid.estimate.results.estimate import Alternative, Diagnostic, Estimate
from motorid.estimate.results.status import Status
from motorid.quality.guard_band import Rule
from motorid.quality.judge import judge, not_measured, not_running
from motorid.quality.product import Product, parse
from motorid.quality.stored_verdict import Stored, judge_stored, surely_within
from motorid.quality.verdict import Measurement, Outcome
from tests.quality.made_estimate import VALUES, estimate, parameter

TEXT = """
[serial]
pattern = "M[0-9]"
[ambient]
low_c = 18
high_c = 28
[capture]
lost_samples = 2
[motor]
voltage_v = 6
[[program.steps]]
kind = "coast"
duration_s = 1
[limits.R]
low = 1.5
high = 2.5
"""
PRODUCT = parse(TEXT, "pump.toml")
RUN = {"serial": "M1", "ambient_c": 20.0, "end_reason": "completed", "gaps": 2}


def made(*runs: dict[str, object], **changes: object) -> Estimate:
    return estimate(inputs=runs or (RUN,), versions={"file": "1"}, **changes)


def judged(name: str, made_: Estimate, product: Product = PRODUCT) -> Measurement:
    return judge(made_, product)[name]


def test_a_motor_that_passes() -> None:
    found = judge(made(), PRODUCT)
    assert (found.outcome, found.product, found.serial) == (Outcome.PASS, "pump", "M1")
    assert [m.quantity for m in found.measurements] == [
        "run_complete", "fit_settled", "current_sensed", "serial", "ambient", "model_fits",
        "nothing_doubtful", "derived_as_measured", "R",
    ]  # fmt: skip
    assert found.inputs == (RUN,)
    assert found.versions.keys() == {"file", "motorid", "product"}
    assert found["R"].reading.value == 2.0
    for m in found.measurements[:5]:
        assert m.limit.condition
    for m in found.measurements[5:]:
        assert not m.limit.condition
    bare = parse(TEXT[TEXT.index("[capture]") :], "p.toml")
    names = {m.quantity for m in judge(made(), bare).measurements}
    assert names.isdisjoint({"serial", "ambient", "model"})


def test_a_serial_number_that_is_given_stands_first() -> None:
    assert judge(made(), PRODUCT, serial="M7").serial == "M7"
    assert judge(made({**RUN, "serial": ""}, {**RUN, "serial": "M2"}), PRODUCT).serial == "M2"
    none = judge(made({"ambient_c": 20.0}), PRODUCT)
    assert (none.serial, none.outcome) == ("", Outcome.INVALID)
    assert "nothing is no serial number" in none["serial"].reason


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gaps": 3}, "the run lost 3 samples: check cable and computer, measure again"),
        ({"end_reason": "stopped"}, "the run ended early (stopped): measure again"),
        ({"gaps": None}, ""), ({"gaps": 2}, ""),
    ],
)  # fmt: skip
def test_a_run_that_is_not_whole(change: dict[str, object], said: str) -> None:
    found = judged("run_complete", made({**RUN, **change}))
    assert (found.reason, found.outcome is Outcome.PASS) == (said, not said)
    assert found.reading.value == float(not said)
    two = judged("run_complete", made(RUN, {**RUN, **change}))
    assert two.reason == said.replace("the run", "run 2")


def test_a_fit_that_did_not_settle_or_does_not_follow() -> None:
    notes = tuple(
        Diagnostic(code, severity, message)
        for code, severity, message in (
            ("lack_of_fit", "warning", "it departs"), ("lack_of_fit", "warning", "again"),
            ("other", "error", "no end"), ("other", "error", "none at all"),
        )
    )  # fmt: skip
    found = judge(made(diagnostics=notes), PRODUCT)
    assert found["fit_settled"].reason == "no end: measure again"
    assert found["model_fits"].reason == "it departs"
    assert found.reasons == ("no end: measure again", "it departs")
    warned = judge(made(diagnostics=notes[:2]), PRODUCT)
    assert (warned["fit_settled"].outcome, warned.outcome) == (Outcome.PASS, Outcome.INVALID)


def doubtful(*names: str) -> dict[str, object]:
    six = {n: parameter(n, v) for n, v in VALUES.items()}
    six |= {n: replace(six[n], status=Status.DOUBTFUL, note=f"why {n}") for n in names}
    return six


def test_doubtful_parameters_are_all_named() -> None:
    found = judge(made(parameters=doubtful("K", "J")), PRODUCT)
    assert found["nothing_doubtful"].reason == "K, J: K is why K"
    assert found.outcome is Outcome.INVALID
    bad = doubtful("K")
    bad["R"] = parameter("R", 3.0)
    assert judge(made(parameters=bad), PRODUCT).outcome is Outcome.FAIL  # a bad motor is still bad


@pytest.mark.parametrize(
    ("ambients", "outcome", "said"),
    [
        ((18.0, 28.0), Outcome.PASS, ""), ((20.0, 17.9), Outcome.INVALID, "17.9 °C is too low"),
        ((28.1,), Outcome.INVALID, "28.1 °C is too high"),
        ((20.0, None), Outcome.INVALID, "give conditions.ambient_c in the rig"),
        ((), Outcome.INVALID, "it is not known"),
    ],
)  # fmt: skip
def test_the_ambient_of_each_run(
    ambients: tuple[float | None, ...], outcome: Outcome, said: str
) -> None:
    runs = [{**RUN, "ambient_c": x, "ambient_uncertainty_c": 0.7} for x in ambients]
    found = [m for m in judge(estimate(inputs=tuple(runs)), PRODUCT).measurements
             if m.quantity == "ambient"]  # fmt: skip
    assert [m.outcome for m in found] == [outcome]
    assert said in found[0].reason
    if outcome is Outcome.PASS:
        assert (found[0].reading.uncertainty, found[0].reading.unit) == (0.7, "°C")
    exact = judged("ambient", made({**RUN, "ambient_uncertainty_c": None}))
    assert exact.reading.uncertainty == 0.0


@pytest.mark.parametrize(
    ("model", "asked", "ohm"), [("better", False, 2.2), ("better", True, 2.0), ("six", False, 2.0)]
)
def test_the_model_that_a_product_judges_by(model: str, asked: bool, ohm: float) -> None:
    six = {n: parameter(n, 1.1 * v) for n, v in VALUES.items()}
    better = Alternative.__new__(Alternative)
    for name, value in (("name", "iron"), ("asked", asked), ("parameters", six)):
        object.__setattr__(better, name, value)
    product = replace(PRODUCT, model=model)
    found = judge(made(alternative=better), product)
    assert found["R"].reading.value == pytest.approx(ohm)
    said = [m.meaning for m in found.measurements if m.quantity == "model"]
    assert said == (["R, L, K, B, J and T0 are those of iron"] if ohm == 2.2 else [])
    assert judge(made(), product)["R"].reading.value == 2.0


def test_what_was_not_measured_at_all() -> None:
    found = not_measured(PRODUCT, "M3", "the cable is out")
    assert (found.outcome, found.serial, found.inputs) == (Outcome.INVALID, "M3", ())
    assert (found.reasons, found["measurement"].reading.problem) == (
        ("the cable is out",), "the cable is out",
    )  # fmt: skip
    assert found.versions["product"] == PRODUCT.digest


@pytest.mark.parametrize(
    ("unsound", "outcome"), [("", Outcome.FAIL), ("no motor", Outcome.INVALID)]
)
def test_a_motor_that_did_not_run(unsound: str, outcome: Outcome) -> None:
    found = not_running(PRODUCT, "M3", "open winding", "no current", unsound)
    assert (found.outcome, found.serial, found.product) == (outcome, "M3", "pump")
    assert found["motor_runs"].reason == "open winding: no current"
    assert (found["motor_runs"].reading.value, found["motor_runs"].limit.low) == (0.0, 1.0)
    said = "motor or rig (open winding; no current): no motor" if unsound else ""
    assert found["rig_sound"].reason == said
    assert found["rig_sound"].limit.condition


# ---- stored --------------------------------------------------------------------------------------


def stored(name: str, value: float | None, outcome: str = "PASS", u: float | None = 0.1) -> Stored:
    return Stored(name, "ohm", value, u, outcome, f"why {name}")


@pytest.mark.parametrize(
    ("rows", "outcome", "reasons"),
    [
        ((stored("R", 2.0),), Outcome.PASS, ()),
        ((stored("R", 2.0, "FAIL"),), Outcome.PASS, ()),
        ((stored("K", 2.0),), Outcome.INVALID, ("Ohmic", "it was not measured then")),
        ((stored("R", None),), Outcome.INVALID, ("why R",)),
        ((stored("R", 2.0), stored("K", 9.0, "FAIL")), Outcome.PASS, ()),
        ((stored("R", 2.0), stored("serial", 0.0, "INVALID")), Outcome.INVALID, ("why serial",)),
        ((stored("R", 9.0), stored("serial", 0.0, "INVALID")), Outcome.INVALID, ("why serial",)),
        ((stored("R", 9.0), stored("model_fits", 0.0, "INVALID")), Outcome.FAIL, ("too high",)),
        ((stored("R", 2.0), stored("motor_runs", 0.0, "FAIL")), Outcome.FAIL, ("why motor_runs",)),
    ],
)
def test_a_verdict_from_what_was_stored(
    rows: tuple[Stored, ...], outcome: Outcome, reasons: tuple[str, ...]
) -> None:
    found = judge_stored(rows, PRODUCT)
    assert (found.outcome, found.product, found.serial) == (outcome, "pump", "")
    assert len(found.reasons) == (outcome is not Outcome.PASS)
    assert not reasons or reasons[-1] in found.reasons[0]


def test_how_far_inside_is_sure() -> None:
    """Each rule's own band of one standard uncertainty, and a billionth."""
    for rule, width in (
        (Rule("simple"), 0.0), (Rule(r=0.5, coverage_factor=3.0), 1.5), (Rule(r=0.0), 0.0),
        (Rule(r=-1.0), 0.0),
        (Rule("specific_risk", consumer_risk=0.1), float(norm.ppf(0.95))),
        (Rule("global_risk", process_mean=0.0, process_sd=1.0), 10.0),
    ):  # fmt: skip
        found = surely_within(rule)
        assert found == pytest.approx(width, rel=1e-8)
        assert found >= width * (1.0 + 1e-10)
