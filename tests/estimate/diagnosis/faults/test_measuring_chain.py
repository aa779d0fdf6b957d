"""Faults of the measuring chain, put into simulated captures, are called by their name."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from motorid.capture.model import CURRENT, VOLTAGE
from motorid.estimate.diagnosis.faults import missing_samples
from motorid.estimate.results.estimate import PARAMETERS, Estimate, Parameter
from motorid.estimate.results.status import Status
from motorid.estimate.signals.time_grid import lay
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import CHAIN, COMMANDED, Case, Runs
from tests.estimate.diagnosis.faults.rigs import DIRECTIONS, DUTIES, Bench
from tests.six_parameters import fit

SIGNS = [c for c in CHAIN if c.code.endswith("_sign")]
# the fit starts from far away, or tries many others before
FAR = {"voltage lag", "slipping load", "mean of currents"}
REPAIRED = {
    "current offset", "offset while driven", "current lag", "position lag", "voltage lag",
    "filtered current", "current averaged", "mean of currents", "current saturated",
    "samples dropped",
}  # fmt: skip
FITTED = [
    pytest.param(c, marks=[pytest.mark.study] if c.name in FAR else [], id=c.name)
    for c in CHAIN
    if c not in SIGNS
]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(Bench("maxon-re35", 3, DUTIES, tmp_path_factory.mktemp("rig")))


@pytest.fixture(scope="module")
def good(runs: Runs) -> Estimate:
    return fit([runs.good])


def named(estimate: Estimate) -> list[str]:
    return [s.code for s in estimate.suspects if s.strength == "named"]


@pytest.mark.slow
@pytest.mark.parametrize("case", FITTED)
def test_a_fault_is_named(case: Case, runs: Runs, good: Estimate) -> None:
    """And estimated where it has a size: as if it were not there, and without it besides."""
    estimate = fit([case.capture(runs)])
    assert named(estimate)[:1] == [case.code]
    first = estimate.suspects[0]
    assert first.evidence
    assert first.action
    assert first.allowed is (case.name in REPAIRED)
    if case.name in REPAIRED:
        assert first.moves == {}
        assert set(first.without) == {*PARAMETERS}
        _agree(estimate, good)
        assert {p.status for p in estimate.parameters.values()} == {Status.ESTIMATED}
        # ripple tells no inductance that readings would tell without the fault
        assert "inductance_by_ripple" not in {d.code for d in estimate.diagnostics}


@pytest.mark.slow
@pytest.mark.parametrize("case", SIGNS, ids=lambda c: c.name)
def test_a_reversed_channel_is_named_and_turned_round(
    case: Case, runs: Runs, good: Estimate
) -> None:
    turned = fit([case.capture(runs)])
    assert named(turned) == [case.code]
    assert turned.suspects[0].allowed
    _agree(turned, good)


@pytest.mark.slow
def test_one_run_of_two_that_lacks_samples_is_repaired(runs: Runs, good: Estimate) -> None:
    bad = inject.dropped(runs.good, 3, 12, 6)
    repaired = fit([runs.good, bad])
    assert repaired.suspects[0].code == "samples_dropped"
    assert repaired.suspects[0].allowed
    _agree(repaired, good)


@pytest.mark.slow
def test_missing_samples_that_are_not_all_seen_are_not_put_back(runs: Runs) -> None:
    """Three more are missing where the motor rests."""
    bad = inject.dropped(runs.good, 3, 12, 6)
    channels = {n: replace(c, raw=np.asarray(c.raw)[3:]) for n, c in bad.channels.items()}
    worse = replace(bad, ticks=bad.ticks[:-3], channels=channels)
    assert missing_samples.put_back(bad, lay(bad)) is not None
    assert missing_samples.put_back(worse, lay(worse)) is None
    first = fit([worse]).suspects[0]
    assert (first.code, first.allowed) == ("samples_dropped", False)


@pytest.mark.slow
def test_a_voltage_declared_late_by_whole_samples_is_as_good_as_one_on_time(
    runs: Runs, good: Estimate
) -> None:
    late = inject.lag(runs.good, VOLTAGE, 3)
    declared = replace(late.channels[VOLTAGE], delay_s=3 * late.period_s)
    found = fit([inject.replaced(late, declared)])
    assert named(found) == []
    _agree(found, good)


def _agree(found: Estimate, good: Estimate) -> None:
    """To within what both leave open."""
    for name, p in good.parameters.items():
        other = found.parameters[name]
        assert other.value == pytest.approx(p.value, abs=math.hypot(_half(p), _half(other))), name


def _half(p: Parameter) -> float:
    assert p.interval_95 is not None
    return (p.interval_95[1] - p.interval_95[0]) / 2


@pytest.mark.slow
@pytest.mark.long
def test_a_supply_limit_is_named_where_volts_are_commanded(tmp_path: Path) -> None:
    bench = Runs(Bench("faulhaber-2338s006s", 1, DIRECTIONS, tmp_path))
    assert named(fit([COMMANDED.capture(bench)], model="six"))[:1] == [COMMANDED.code]


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
    """The voltage is high, and so clipped, in the second level."""
    estimate = fit([inject.clip(runs.good, 0.9 * runs.peak_v, VOLTAGE)])
    said = next(d.message for d in estimate.diagnostics if d.code == "lack_of_fit")
    assert "in the acceleration segment from" in said
    assert "Hz" in said
