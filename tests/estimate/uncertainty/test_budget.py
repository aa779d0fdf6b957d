"""The lines of a budget: they sum to the variance that is stated, and each has a remedy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from motorid.estimate.effects.registry import REGISTRY
from motorid.estimate.effects.source.wiring_resistance import WIRING_RESISTANCE
from motorid.estimate.fit.parameter_bounds import unknowns_of
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.tangent import tangent
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty import budget
from motorid.estimate.uncertainty.covariance import statistical
from motorid.estimate.uncertainty.findings import findings, scattered
from motorid.estimate.uncertainty.intervals import Findings, budget_shares, parameters
from tests.estimate.effects.benches import BENCHES, FAULHABER
from tests.exact_capture import noisy

KINDS = ("measured", "diodes", "commanded", "noisy_source", "filtered")


@cache
def fitted(name: str, runs: int = 1) -> tuple[tuple[MotorRecord, ...], Solution]:
    captures = [noisy(BENCHES[name](), 7 + k, 2e-3, 2e-4) if "voltage" in BENCHES[name]().channels
                else BENCHES[name]() for k in range(runs)]  # fmt: skip
    records = tuple(MotorRecord(capture, PARAMETERS, {}) for capture in captures)
    unknowns = unknowns_of(records, PARAMETERS, FAULHABER)
    return records, maximise(unknowns, records)


@cache
def found(name: str, runs: int = 1) -> Findings:
    records, solution = fitted(name, runs)
    return findings(records, solution, {}, (), profiled=False)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("runs", [1, 3])
def test_lines_sum_to_the_variance_of_every_parameter(name: str, runs: int) -> None:
    lines, stated = budget_shares(found(name, runs)), parameters(found(name, runs))
    known = {name: p.total for name, p in stated.items() if p.total is not None}
    told = {"R", "K", "J", "T0"}
    if name != "noisy_source":  # whose levels are too uncertain to tell B from none
        told |= {"B"}
    assert set(known) >= told
    for parameter, total in known.items():
        assert sum(u**2 for u in lines[parameter].values()) == pytest.approx(total**2, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_every_line_has_a_remedy(name: str) -> None:
    for lines in budget_shares(found(name)).values():
        for cause in lines:
            assert budget.remedy(cause)


def test_every_influence_quantity_and_every_rest_has_a_remedy() -> None:
    for cause in (*(q.name for q in REGISTRY), *budget.REST):
        assert len(budget.remedy(cause)) > 5


@pytest.mark.slow
def test_a_gain_of_the_current_scales_what_it_must() -> None:
    """i → (1 + g) i at the same volts and speed: R, L, K, B, J, T0 by −g, −g, 0, and g."""
    records, solution = fitted("commanded")
    moved = budget.propagated(solution, records)["current gain"]
    share = dict(zip(PARAMETERS, moved / 0.01, strict=True))  # of the declared 1 %
    assert np.sign(share["R"]) == -np.sign(share["J"])
    assert abs(share["R"]) == pytest.approx(1.0, abs=0.2)
    assert abs(share["J"]) == pytest.approx(1.0, abs=0.2)


def test_a_winding_of_less_resistance_than_the_wiring_s_has_a_budget_too() -> None:
    """A fit of readings that no motor gives may end there."""
    records, solution = fitted("commanded")
    values = np.where([u.name == "R" for u in solution.unknowns], 1e-15, solution.values)
    told = [one for one, _ in records[0].propagated]
    assert WIRING_RESISTANCE in [one.quantity for one in told]
    for one in told:
        for moved in tangent(records[0], values, solution.own[0], one):
            assert np.isfinite(moved).all(), one.name


def test_priors_only_widen() -> None:
    records, solution = fitted("commanded")
    known = budget.of_priors(solution, records)
    plain, whole = statistical(solution), scattered(solution, records, ())
    assert set(known.shifts) <= {q.name for q in REGISTRY}
    assert (np.diag(whole.covariance) >= np.diag(plain.covariance) * (1 - 1e-9)).all()
