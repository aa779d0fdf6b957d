"""Faults of the measuring chain, put into simulated captures, are called by their name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from motorid.capture.model import CURRENT
from motorid.errors import DataError
from motorid.estimate.fit.sign_check import WrongSignError
from motorid.estimate.results.estimate import Estimate
from motorid.identify import fit
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import CHAIN, COMMANDED, Case, Runs
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, DUTIES, Bench

SIGNS = [c for c in CHAIN if c.code.endswith("_sign")]
SLOW = {"voltage lag", "filtered current"}  # fits that start from far away
FITTED = [
    pytest.param(c, marks=[pytest.mark.slow] if c.name in SLOW else [], id=c.name)
    for c in CHAIN
    if c not in SIGNS
]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(Bench("maxon-re35", 3, DUTIES, tmp_path_factory.mktemp("rig")))


def named(estimate: Estimate) -> list[str]:
    return [s.code for s in estimate.suspects if s.strength == "named"]


@pytest.mark.slow
@pytest.mark.parametrize("case", FITTED)
def test_a_fault_is_named(case: Case, runs: Runs) -> None:
    estimate = fit([case.capture(runs)])
    assert named(estimate)[:1] == [case.code]
    first = estimate.suspects[0]
    assert first.evidence
    assert first.action


@pytest.mark.parametrize("case", SIGNS, ids=lambda c: c.name)
def test_a_reversed_channel_is_refused_before_the_fit(case: Case, runs: Runs) -> None:
    with pytest.raises(DataError, match="sign of the") as caught:
        fit([case.capture(runs)])
    assert isinstance(caught.value, WrongSignError)
    assert caught.value.suspect.code == case.code
    assert "\n" not in str(caught.value)


@pytest.mark.slow
@pytest.mark.long
def test_a_supply_limit_is_named_where_volts_are_commanded(tmp_path: Path) -> None:
    bench = Runs(Bench("faulhaber-2338s006s", 1, DIRECTIONS, tmp_path))
    assert named(fit([COMMANDED.capture(bench)]))[:1] == [COMMANDED.code]


@pytest.mark.slow
@pytest.mark.parametrize("motor", ["qube-servo", "pittman-14204s004", "dunkermotoren-gr42"])
def test_a_good_capture_raises_no_alarm(motor: str, tmp_path: Path) -> None:
    bench = Bench(motor, 5, DUTIES, tmp_path)
    assert named(fit([bench.capture()])) == []
    rough = f"&cogging={0.2 * bench.preset.coulomb_nm:g}&ripple=0.01"
    assert named(fit([bench.capture(rough)])) == []


@pytest.mark.slow
def test_the_size_is_found(runs: Runs) -> None:
    late = inject.decimated(inject.lag(runs.fine, CURRENT, 4))
    first = fit([late]).suspects[0]
    microseconds = float(first.evidence.split(" µs")[0].split()[-1])
    assert microseconds == pytest.approx(200, abs=10)


@pytest.mark.slow
def test_a_lag_beyond_what_is_declared_of_a_delay_is_named(runs: Runs) -> None:
    """A delay that is an unknown of the fit takes up no more than its declaration allows."""
    late = inject.decimated(inject.lag(runs.fine, CURRENT, 4))
    unsure = replace(late.channels[CURRENT], delay_uncertainty_s=1.5e-6)
    assert named(fit([inject.replaced(late, unsure)]))[:1] == ["current_lag"]


@pytest.mark.slow
def test_one_bad_run_of_several_is_pointed_at(runs: Runs) -> None:
    bad = inject.held(runs.good, 1, 0.1, 60)
    first = fit([runs.good, bad]).suspects[0]
    assert first.code == "readings_held"
    assert "(run 2)" in first.evidence


@pytest.mark.slow
def test_the_one_run_that_misfits_is_looked_at_alone(runs: Runs) -> None:
    bad = inject.clip(runs.good, 0.7 * runs.peak_a)
    first = fit([runs.good, bad]).suspects[0]
    assert first.code == "current_saturated"
    assert "(run 2)" in first.evidence


@pytest.mark.slow
def test_a_lack_of_fit_says_where(runs: Runs) -> None:
    """The current is high, and so clipped, where the motor accelerates."""
    estimate = fit([inject.clip(runs.good, 0.7 * runs.peak_a)])
    said = next(d.message for d in estimate.diagnostics if d.code == "lack_of_fit")
    assert "in the acceleration segment from" in said
    assert "Hz" in said
