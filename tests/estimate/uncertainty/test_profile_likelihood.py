"""Intervals by the likelihood's profile, against a brute force of fits with the parameter held."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import Capture
from motorid.estimate.fit import joint_fit
from motorid.estimate.uncertainty.covariance import covariance_of
from motorid.estimate.uncertainty.findings import findings
from motorid.estimate.uncertainty.profile_likelihood import Profile, interval
from tests.exact_capture import FAULHABER, Plan, clean_capture, noisy
from tests.six_parameters import fit

CLEAN = clean_capture({**FAULHABER, "B": 0.0}, Plan(count=800))
CHI_SQUARE_95 = 1.959964**2


@pytest.fixture(scope="module")
def weak() -> Capture:
    """A short noisy run of a motor without viscous friction."""
    return noisy(CLEAN, 1, 4e-2, 1e-2, 0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["B", "T0", "L"])
def test_the_ends_are_where_a_brute_force_finds_them(weak: Capture, name: str) -> None:
    """A whole fit by its own door, with the parameter given, has lost just as much there."""
    records, solution = joint_fit.solved([weak], {}, ())
    place = [u.name for u in solution.unknowns].index(name)
    white = float(np.sqrt(covariance_of(solution.information)[place, place]))
    ends = interval(solution, records, place, 1.959964 * white, white)
    for end in ends:
        if end > 0:
            _, held = joint_fit.solved([weak], {name: end}, ())
            fallen = held.objective - solution.objective
            assert fallen == pytest.approx(CHI_SQUARE_95, rel=0.07)
            root = Profile(solution, records, place).root(end)
            assert root**2 == pytest.approx(fallen, rel=0.01)
    assert ends[0] < solution.values[place] < ends[1] or solution.at_bound[place]


@pytest.mark.slow
def test_a_leaning_likelihood_gives_a_leaning_interval(weak: Capture) -> None:
    """B is held at 0, so T0 cannot be much larger than it is, and may be a good deal smaller."""
    found = fit([weak])
    low, high = found.parameters["T0"].interval_95
    assert found.parameters["B"].status == "at_bound"
    assert low < FAULHABER["T0"] < high
    records, solution = joint_fit.solved([weak], {}, ())
    ends = findings(records, solution, {}, ()).profiles  # what the instruments add is even
    place = [u.name for u in solution.unknowns].index("B")
    parabola = 1.96 * float(np.sqrt(covariance_of(solution.information)[place, place]))
    assert 0 < ends["B"][1] < 0.9 * parabola
    (low, high), value = ends["T0"], found.parameters["T0"].value
    assert high - value < 0.5 * (value - low)


@pytest.mark.slow
def test_intervals_at_a_bound_hold_the_truth() -> None:
    """30 runs of a motor whose B is 0: at least 26 of 95 % intervals hold it and T0, L."""
    held = dict.fromkeys(("B", "T0", "L"), 0)
    for seed in range(30):
        found = fit([noisy(CLEAN, seed, 4e-2, 1e-2, 0.02)]).parameters
        for name in held:
            ends = found[name].interval_95
            true = 0.0 if name == "B" else FAULHABER[name]
            held[name] += ends is None or ends[0] <= true <= ends[1]
    assert min(held.values()) >= 26, held
