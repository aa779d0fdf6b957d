"""Whether rows support a further term of a balance, against what solving without it gives."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.partial import further_terms as module
from motorid.estimate.partial.block_bootstrap_regression import Regression, solve
from motorid.estimate.partial.modulating_functions import LATE, SQUARE, Rows

TRUTH = np.array([0.02, 0.05, 0.3, 0.01])
COUNT = 96


def rows(square: float = 0.0, late: float = 0.0, noise: float = 0.01) -> Rows:
    rng = np.random.default_rng(7)
    matrix = rng.standard_normal((COUNT, 4))
    shapes, delay = rng.standard_normal((COUNT, 3)), rng.standard_normal(COUNT)
    drive = matrix @ TRUTH + square * shapes[:, 0] + late * delay
    drive += noise * rng.standard_normal(COUNT)
    ones = np.ones(COUNT)
    stretch, capture = np.arange(COUNT) // 8, np.zeros(COUNT, dtype=int)
    return Rows(matrix, drive, ones, ones, stretch, capture, shapes, delay)


def solved(given: Rows, *terms: str, free: object = None) -> Regression:
    n = 4 + len(terms)
    wanted = np.ones(n, bool) if free is None else np.array(free)
    return solve(given.beside(*terms), wanted, np.zeros(n), 0.1)


def test_terms_stand_behind_the_columns_and_plain_ones_are_left() -> None:
    given = rows()
    beside = given.beside(LATE, SQUARE)
    assert beside.matrix[:, 4].tolist() == given.late.tolist()
    assert beside.matrix[:, 5].tolist() == given.shapes[:, 0].tolist()
    assert given.beside() is given
    found = solved(given, SQUARE)
    plain = found.plain()
    assert plain.coefficients.tolist() == found.coefficients[:4].tolist()
    assert plain.covariance.tolist() == found.covariance[:4, :4].tolist()
    assert plain.rows.matrix.tolist() == given.matrix.tolist()
    assert (len(plain.free), len(plain.at_bound)) == (4, 4)


def test_moves_widen_what_is_free() -> None:
    plain = solved(rows(), free=[True, True, True, False])
    moves = np.array([1.0, 2.0, 3.0, 4.0]), np.array([0.0, 5.0, 0.0, 0.0])
    wider = plain.widened(*moves)
    expected = np.outer([1, 2, 3, 0], [1, 2, 3, 0]) + np.diag([0.0, 25.0, 0.0, 0.0])
    np.testing.assert_allclose(wider.covariance - plain.covariance, expected, atol=1e-12)
    assert plain.widened().covariance.tolist() == plain.covariance.tolist()


@pytest.mark.parametrize("size", [0.0, 0.1])
def test_the_gain_is_what_the_residuals_lose(size: float) -> None:
    given = rows(square=size)
    without, beside = solved(given), solved(given, SQUARE)
    ratio = float(without.residual @ without.residual / (beside.residual @ beside.residual))
    assert module.gain(beside, 4) == pytest.approx(COUNT / 2 * np.log(ratio))
    assert (module.gain(beside, 4) > module.NEEDED) is (size > 0.01)


def test_what_the_drive_has_already_counts() -> None:
    """A delay that was taken from the drive: without it the rows would be as before."""
    given = rows(late=0.05)
    taken = solved(rows(late=0.0), LATE)
    whole = solved(given, LATE)
    assert module.gain(taken, 4) < 5.0
    assert module.gain(taken, 4, 0.05) == pytest.approx(module.gain(whole, 4), rel=1e-6)


def test_rows_that_nothing_is_left_of_are_explained() -> None:
    exact = solved(rows(square=0.1, noise=0.0), SQUARE)
    assert module.gain(exact, 4) > 1000.0


@pytest.mark.parametrize("free", [[True] * 6, [True, True, False, True, True, True]])
def test_the_slope_is_how_far_the_others_move(free: list[bool]) -> None:
    given = rows()
    found = solved(given, SQUARE, LATE, free=free)
    slope = module.slope(found, 4)
    part = given.beside(SQUARE, LATE).matrix
    others = [k for k, one in enumerate(free) if one and k != 4]

    def answer(square: float) -> np.ndarray:
        out = np.zeros(6)
        left = given.drive - square * part[:, 4]
        out[others] = np.linalg.lstsq(part[:, others], left, rcond=None)[0]
        return out

    np.testing.assert_allclose(slope, (answer(2.0) - answer(1.0))[:4], rtol=1e-6, atol=1e-9)


def test_what_is_left_open_is_usual_or_as_the_data_say() -> None:
    assert module.left_open(0.0, 1e9, 2.0) == pytest.approx(2.0)  # they say nothing
    assert module.left_open(0.0, 0.1, 1e9) == pytest.approx(0.1)  # they say all
    assert module.left_open(1.0, 1.0, 1e-6) < 1e-5
    assert module.left_open(3.0, 1.0, 1e-6) == pytest.approx(np.hypot(2.7, np.sqrt(0.9)))
    assert module.left_open(1.0, 1.0, 0.0) == 0.0
