"""All comparisons together, as a fit makes them."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from motorid.capture.model import SUPPLY_BEFORE, Capture
from motorid.estimate.diagnosis.facts.compare import findings
from motorid.estimate.results.status import Status
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.report import example
from tests.six_parameters import fit

K = FAULHABER["K"]


def run(serial: str = "", **motor: float) -> Capture:
    """A run of a motor, with a little noise."""
    capture = noisy(clean_capture({**FAULHABER, **motor}, Plan()), 1, 1e-3, 1e-4)
    return replace(capture, provenance={"serial": serial})


@pytest.mark.slow
def test_every_capture_is_compared() -> None:
    capture = run()
    wiring = replace(capture.wiring, supply_voltage_v=9.0, pwm_hz=20e3)
    known = {SUPPLY_BEFORE: 7.0, "identity": {}}
    wrong = replace(capture, wiring=wiring, provenance=known)
    estimate = example.estimate()
    found = list(findings([capture, wrong], estimate, lambda _: estimate))
    assert [said.code for said in found] == ["supply_contradicted"]
    assert "in run 2" in found[0].message


@pytest.mark.slow
def test_two_motors_in_one_fit_are_named_and_their_k_is_doubtful() -> None:
    estimate = fit([run("M17"), run("M18", K=1.1 * K)])
    assert "serials_differ" in [d.code for d in estimate.diagnostics]
    k = estimate.parameters["K"]
    assert k.status is Status.DOUBTFUL
    assert k.interval_95 is not None
    assert k.interval_95[0] < K
    assert k.interval_95[1] > 1.1 * K
    assert k.interval_95[1] - k.interval_95[0] == pytest.approx(0.15 * K, rel=0.5)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1.1, 1.01])
def test_two_motors_that_nobody_names_differ_by_what_each_run_says_alone(factor: float) -> None:
    estimate = fit([run(), run(K=factor * K)])
    (said,) = [d for d in estimate.diagnostics if d.code == "runs_differ"]
    found = re.search(r"about ([0-9.]+) % in K, as of another motor", said.message)
    assert found is not None
    assert float(found[1]) == pytest.approx(100.0 * (factor - 1.0), rel=0.15)
    k = estimate.parameters["K"]
    assert k.status is Status.DOUBTFUL
    assert k.interval_95 is not None
    assert k.interval_95[0] < 1.01 * K
    assert k.interval_95[1] > 0.99 * factor * K


@pytest.mark.slow
def test_one_motor_twice_is_not_doubted() -> None:
    estimate = fit([run("M17"), run("M17")])
    assert [d.code for d in estimate.diagnostics if d.severity != "info"] == []
    assert estimate.parameters["K"].status is Status.ESTIMATED
