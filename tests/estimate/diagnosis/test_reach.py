"""How far faults could have moved the parameters: more than they did, and not by much."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.capture.model import VOLTAGE
from motorid.estimate.diagnosis import reach
from motorid.estimate.diagnosis.suspects import suspects
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.results.estimate import Diagnostic, Estimate, Suspect
from tests.estimate.diagnosis.faults import inject
from tests.estimate.diagnosis.faults.cases import Runs
from tests.estimate.diagnosis.faults.rigs import DUTIES, Bench
from tests.six_parameters import fit

WIDEST = 3.0  # times the error that the fault made


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    return Runs(Bench("faulhaber-2338s006s", 3, DUTIES, tmp_path_factory.mktemp("rig")))


@pytest.fixture(scope="module")
def good(runs: Runs) -> Estimate:
    return fit([runs.good], model="six")


def error(found: Estimate, runs: Runs, name: str) -> tuple[float, float]:
    """By how much a parameter is off the motor's own, and how far its interval reaches that way.

    No friction is below nothing: an interval that ends there reaches farther to the other side.
    """
    m, p = runs.bench.preset, found.parameters[name]
    truth = {
        "R": m.resistance_ohm, "L": m.inductance_h, "K": m.torque_constant_nm_a,
        "B": m.viscous_nm_s, "J": m.inertia_kg_m2, "T0": m.coulomb_nm,
    }  # fmt: skip
    assert p.value is not None
    assert p.interval_95 is not None
    low, high = p.interval_95
    reach = high - p.value if truth[name] > p.value else p.value - low
    return abs(p.value - truth[name]), reach


@pytest.mark.slow
def test_a_good_capture_has_no_doubtful_parameter(good: Estimate) -> None:
    assert {p.status for p in good.parameters.values()} == {"estimated"}


@pytest.mark.slow
def test_lost_counts_are_sized_by_the_travel(runs: Runs) -> None:
    found = fit([inject.lost_counts(runs.good, 3, 40, 60)], model="six")
    assert found.suspects[0].code == "encoder_loses_counts"
    for name in ("K", "J", "B", "T0"):
        off, half = error(found, runs, name)
        assert off < half < WIDEST * off
        if name != "B":  # which no lost count moves beyond what the levels leave open of it
            assert found.parameters[name].status == "doubtful"
    assert found.parameters["L"].status == "estimated"


@pytest.mark.study
def test_a_saturated_voltage_is_covered(runs: Runs) -> None:
    found = fit([inject.clip(runs.good, 0.9 * runs.peak_v, VOLTAGE)], model="six")
    for name in ("R", "L", "J", "B", "K"):
        off, half = error(found, runs, name)
        assert found.parameters[name].status == "doubtful"
        assert found.budget[name]["finding: voltage saturated"] > 0.0
        assert off < half < WIDEST * off
        assert sum(u**2 for u in found.budget[name].values()) == pytest.approx(
            (found.parameters[name].total or 0.0) ** 2, rel=1e-9
        )


@pytest.mark.slow
def test_a_good_folder_stays_good(runs: Runs, tmp_path: Path) -> None:
    """Readings that repeat now and then move little, and nothing is widened by much."""
    found = fit([inject.held(runs.good, 3, 0.02, 10)], model="six")
    for p in found.parameters.values():
        assert p.interval_95 is not None
        assert p.value is not None
        assert p.interval_95[1] - p.interval_95[0] < 0.05 * p.value


@pytest.mark.slow
def test_parts_of_a_good_run_agree_and_nothing_is_hidden(runs: Runs, good: Estimate) -> None:
    records, solution = solved([runs.good], {}, ())
    parts, norm = reach.disagreement(records, solution), reach.hidden(records, solution)
    for name, p in good.parameters.items():
        assert parts[name] < 0.5 * (p.total or 0.0) + norm[name]
    half = reach.hidden(records, solution, 0.25)
    assert half == {name: pytest.approx(0.5 * most) for name, most in norm.items()}
    assert not [s for s in suspects(records, solution, good.parameters)[0] if s.strength == "named"]


@pytest.mark.slow
def test_a_lack_that_a_named_fault_explains_moves_nothing_itself(
    runs: Runs, good: Estimate
) -> None:
    records, solution = solved([runs.good], {}, ())
    lack = Diagnostic("lack_of_fit", "warning", "it lacks something")
    lag = Suspect("current_lag", "current", "it is late", "declare it", "named", {"R": 0.1})
    six = good.parameters
    assert reach.of_lack([lack], [lag], records, solution, six) == (lack,)
    (alone,) = reach.of_lack([lack], [], records, solution, six)
    assert not alone.moves  # too small to matter
    assert alone.message == f"{lack.message}; the parts of the program agree on every parameter"


@pytest.mark.slow
def test_a_lack_names_what_it_can_move(runs: Runs) -> None:
    capture = inject.clip(runs.good, 0.7 * runs.peak_a)
    records, solution = solved([capture], {}, ())
    moves = reach.disagreement(records, solution)
    assert any(moves.values())
    lack = Diagnostic("lack_of_fit", "warning", "it lacks something")
    wide = dict(zip(moves, (0.2, 5.0) * 3, strict=True))  # of its interval, in moves
    parameters: dict[str, Any] = {
        name: SimpleNamespace(value=1.0, interval_95=(0.0, move * wide[name]))
        for name, move in moves.items()
    }
    (said,) = reach.of_lack([lack], [], records, solution, parameters)
    for name, move in moves.items():
        assert (f"{name} by" in said.message) == (move > 0.0 and wide[name] < 4.0)
