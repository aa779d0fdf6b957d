"""Nuisances eliminated, where sums of products serve and where they have too few digits."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.solver.normal_equations import Normal
from motorid.estimate.solver.schur_complement import by_rows, by_sums

N, NONE = 4000, np.zeros(3, dtype=bool)


def normal_of(shared: np.ndarray, own: np.ndarray, precision: np.ndarray) -> Normal:
    oo = own @ own.T + np.diag(precision)
    return Normal(shared @ shared.T, shared @ own.T, oo, np.zeros(len(shared)), np.zeros(len(own)))


@pytest.mark.parametrize("held", [NONE, np.array([False, True, False])])
def test_sums_and_rows_agree_where_both_have_digits(held: np.ndarray) -> None:
    rng = np.random.default_rng(1)
    own, shared = rng.standard_normal((3, N)), rng.standard_normal((2, N))
    precision = np.array([0.0, 4.0, 1e3])
    normal = normal_of(shared, own, precision)
    sums, rows = by_sums(normal, held), by_rows(shared, own, precision, held)
    assert not sums.doubtful(normal)
    for name in ("left", "follows", "inverse"):
        np.testing.assert_allclose(getattr(rows, name), getattr(sums, name), rtol=1e-9, atol=1e-12)


def test_rows_keep_what_nuisances_that_are_nearly_alike_leave() -> None:
    rng = np.random.default_rng(2)
    basis, _ = np.linalg.qr(rng.standard_normal((N, 4)))
    a, b, c, apart = basis.T
    own = 1e3 * np.array([a, a + 1e-5 * b, c])
    shared = 1e6 * (a + 3.0 * b + c)[None] + 0.5 * apart[None]  # all but .5 is explained
    normal = normal_of(shared, own, np.zeros(3))
    assert by_sums(normal, NONE).doubtful(normal)
    found = by_rows(shared, own, np.zeros(3), NONE)
    # own's rounding, 1e-16, is 1e-11 of what parts the two, and shared is 6e6 of what is left
    assert found.left[0, 0] == pytest.approx(0.25, rel=1e-4)
    left = shared - found.follows.T @ own
    assert float(left[0] @ left[0]) == pytest.approx(0.25, rel=1e-3)


def test_a_nuisance_that_moves_nothing_takes_nothing() -> None:
    rng = np.random.default_rng(3)
    own, shared = rng.standard_normal((3, N)), rng.standard_normal((1, N))
    own[1] = 0.0
    two = by_rows(shared, own[[0, 2]], np.zeros(2), NONE[:2])
    assert by_rows(shared, own, np.zeros(3), NONE).left == pytest.approx(two.left)
