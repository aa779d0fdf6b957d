"""Which declared doubts the readings tell better than their declaration."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, Capture
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.source.voltage_gain import VOLTAGE_GAIN
from motorid.estimate.effects.timing.current_delay import CURRENT_DELAY
from motorid.estimate.fit import promotion
from motorid.estimate.fit.parameter_bounds import unknowns_of
from motorid.estimate.fit.promotion import contradicted, promoted
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Solution
from tests.estimate.effects.benches import FAULHABER, instants, measured
from tests.exact_capture import noisy

DELAY = Instance(CURRENT_DELAY)


def uncertain(capture: Capture, delay_sd_s: float) -> Capture:
    """With so uncertain a delay of the current, and no filter."""
    current = replace(
        capture.channels[CURRENT], delay_uncertainty_s=delay_sd_s, filter_s=0.0, delay_s=1e-5
    )
    return replace(capture, channels={**capture.channels, CURRENT: current})


def fitted(capture: Capture) -> tuple[list[MotorRecord], Solution]:
    records = [MotorRecord(noisy(capture, 3, 1e-3, 1e-4), PARAMETERS, {})]
    return records, maximise(unknowns_of(records, PARAMETERS, FAULHABER), records)


@cache
def rippling() -> tuple[list[MotorRecord], Solution]:
    return fitted(uncertain(instants(), 3e-6))


@pytest.mark.slow
def test_a_delay_that_ripple_shows_becomes_an_unknown() -> None:
    records, solution = rippling()
    before = records[0].unknowns
    told, found = promoted(records, solution)
    assert found == [DELAY]
    assert [u.name for u in records[0].unknowns] == [*(u.name for u in before), "current delay"]
    assert len(told.own[0]) == len(solution.own[0]) + 1
    assert told.own[0][-1] == 0.0  # it begins as declared
    assert DELAY not in [one for one, _ in records[0].propagated]
    records[0].propagate(DELAY)  # put back: as it was
    assert records[0].unknowns == before
    assert DELAY in [one for one, _ in records[0].propagated]


@pytest.mark.slow
@pytest.mark.parametrize("sd_s", [1e-12, 3e-6])
def test_what_no_reading_shows_stays_as_declared(sd_s: float) -> None:
    """A mean over whole periods; or a delay that is known better than any reading could tell."""
    capture = measured() if sd_s > 1e-9 else instants()
    records, solution = fitted(uncertain(capture, sd_s))
    same, found = promoted(records, solution)
    assert same is solution
    assert found == []


def test_a_gain_is_never_told() -> None:
    """It leaves no residual: whatever the readings."""
    records, _ = rippling()
    assert VOLTAGE_GAIN.name in [one.quantity.name for one, _ in records[0].propagated]
    assert not VOLTAGE_GAIN.told(records[0])


@pytest.mark.parametrize(("share", "beyond"), [(0.0, False), (0.5, False), (1.0, True)])
def test_a_quantity_at_its_bound_contradicts_its_declaration(share: float, beyond: bool) -> None:
    records, solution = rippling()
    _, found = promoted(records, solution)
    try:
        upper = records[0].unknowns[-1].upper
        own = np.append(solution.own[0], share * upper)
        assert contradicted(records, replace(solution, own=(own,)), found) is beyond
    finally:
        records[0].propagate(*found)


def system(strength: float, own: bool) -> tuple[Any, Any, np.ndarray, np.ndarray]:
    """Records, a solution, the readings' change by the doubt, and by all else."""
    rng = np.random.default_rng(8)
    A, C = rng.standard_normal((60, 2)), rng.standard_normal((60, 1 if own else 0))
    column = strength * (rng.standard_normal(60) + 3.0 * A[:, 0] + (2.0 * C[:, 0] if own else 0.0))
    information = C.T @ C
    orthogonal = A - C @ np.linalg.solve(information, C.T @ A) if own else A
    sigmas = np.array([0.5, 2.0])
    line = SimpleNamespace(
        orthogonal=orthogonal, own=C, own_information=information, sigmas=sigmas,
        slices=(slice(0, 20), slice(20, 60)),
    )  # fmt: skip
    solution = SimpleNamespace(information=A.T @ orthogonal, records=(line,))
    unweighed = column * np.repeat(sigmas, [20, 40])
    return solution, unweighed, column, np.column_stack([A, C])


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("strength", [0.003, 0.02, 0.03, 0.04, 0.05, 0.1, 1.0])
def test_a_doubt_pays_where_it_takes_a_tenth_of_a_variance(strength: float, own: bool) -> None:
    """Against the covariance of all unknowns, the doubt with a prior of one among them."""
    solution, unweighed, column, others = system(strength, own)
    every = np.column_stack([others, column])
    unit = np.diag([*[0.0] * others.shape[1], 1.0])
    told = np.diag(np.linalg.inv(every.T @ every + unit))[:2]
    alone = np.linalg.inv(others.T @ others)
    shift = (alone @ others.T @ column)[:2]
    propagated = np.diag(alone)[:2] + shift**2
    pays = bool((told < 0.9 * propagated).any())
    assert promotion._pays([unweighed], [1.0], solution) is pays
    assert promotion._pays([unweighed / 3.0], [3.0], solution) is pays
    assert (strength, pays) not in ((0.003, True), (1.0, False))


def test_a_doubt_that_the_others_explain_never_pays() -> None:
    solution, _, _, others = system(1.0, True)
    mixed = 5.0 * others[:, 0] - others[:, 2]
    weighed = mixed * np.repeat([0.5, 2.0], [20, 40])
    assert not promotion._pays([weighed], [1.0], solution)
