"""The vector that a search moves in: logarithms, bounds, priors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from motorid.estimate.solver.problem import Unknown
from motorid.estimate.solver.search_coordinates import Coordinates

UNKNOWNS = (
    Unknown("R", 2.0, log=True, prior_mean=0.5, prior_sd=0.1),
    Unknown("B", 3e-5, lower=0.0, scale=1e-4),
    Unknown("share", 0.5, lower=0.0, upper=1.0, scale=1.0, prior_mean=0.4, prior_sd=0.2),
    Unknown("L", 1e-3, lower=5e-4, upper=4e-3, log=True),
)
FRAME = Coordinates(UNKNOWNS)
VALUES = np.array([2.0, 3e-5, 0.5, 1e-3])


def test_positive_ones_are_moved_by_their_logarithm() -> None:
    assert FRAME.start == pytest.approx([math.log(2), 3e-5, 0.5, math.log(1e-3)])
    assert FRAME.outward(FRAME.inward(VALUES)) == pytest.approx(VALUES)
    assert FRAME.slopes(FRAME.start) == pytest.approx([2.0, 1.0, 1.0, 1e-3])


def test_bounds_and_the_reach_of_a_logarithm() -> None:
    assert FRAME.lower == pytest.approx([math.log(2) - 14, 0.0, 0.0, math.log(5e-4)])
    assert FRAME.upper == pytest.approx([math.log(2) + 14, np.inf, 1.0, math.log(4e-3)])
    assert FRAME.clipped(np.array([2.0, -1.0, 3.0, 1.0])) == pytest.approx(
        [math.log(2), 0.0, 1.0, math.log(4e-3)]
    )


def test_a_start_beyond_its_bounds_begins_at_one() -> None:
    assert Coordinates([Unknown("x", 5.0, upper=2.0)]).start.tolist() == [2.0]
    assert Coordinates([Unknown("x", 0.0, lower=1.0)]).start.tolist() == [1.0]


def test_priors_are_counted_in_deviations() -> None:
    x = FRAME.start + np.array([0.2, 1.0, 0.0, 1.0])
    wanted = ((math.log(2) + 0.2 - 0.5) / 0.1) ** 2 + ((0.5 - 0.4) / 0.2) ** 2
    assert FRAME.prior(x) == pytest.approx(wanted)


def test_distances_are_relative_or_of_the_scale() -> None:
    a = FRAME.start
    assert FRAME.apart(a, a + np.array([0.01, 0, 0, 0])) == pytest.approx(0.01)
    assert FRAME.apart(a, a + np.array([0, -2e-6, 0, 0])) == pytest.approx(0.02)
    assert FRAME.apart(a, a + np.array([0.01, 5e-6, 0.001, 0])) == pytest.approx(0.05)


def test_a_difference_goes_back_where_forward_leaves_the_bounds() -> None:
    assert FRAME.difference(FRAME.start, 2) == pytest.approx(1e-6)
    assert FRAME.difference(FRAME.upper, 2) == pytest.approx(-1e-6)
    assert FRAME.difference(FRAME.start + np.array([0, 7.0, 0, 0]), 1) == pytest.approx(
        7e-6, rel=1e-4
    )  # far above
    assert FRAME.difference(FRAME.start, 1) == pytest.approx(1e-10)


def test_derivatives_grow_with_the_values() -> None:
    now = FRAME.start + np.array([math.log(3.0), 1.0, 0.2, 0.0])
    assert FRAME.growth(FRAME.start, now)[:, 0] == pytest.approx([3.0, 1.0, 1.0, 1.0])


def test_what_is_at_a_bound_and_pulled_out_is_blocked() -> None:
    frame = Coordinates([Unknown("a", 0.0, lower=0.0), Unknown("b", 1.0, upper=1.0)])
    assert frame.blocked(frame.start, np.array([-1.0, 1.0])).tolist() == [True, True]
    assert frame.blocked(frame.start, np.array([1.0, -1.0])).tolist() == [False, False]
    assert frame.blocked(np.array([0.5, 0.5]), np.array([-1.0, 1.0])).tolist() == [False, False]
    assert frame.blocked(frame.start, np.zeros(2)).tolist() == [False, False]


def test_a_difference_may_reach_the_bound_itself() -> None:
    assert Coordinates([Unknown("x", 0.0, upper=1e-6)]).difference(np.zeros(1), 0) == 1e-6
