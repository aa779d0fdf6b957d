"""Regression of correlated rows: against formulas, and fits that leave out one block each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.partial import block_bootstrap_regression as module
from motorid.estimate.partial.block_bootstrap_regression import Regression, blocks, choose_width
from motorid.estimate.partial.modulating_functions import Rows

Floats = NDArray[np.float64]
TRUTH = np.array([2.0, 0.5, 3.0, -1.0])
ALL = np.ones(4, dtype=np.bool_)
SCALES = np.array([1.0, 30.0, 0.2, 4.0])


def rows(
    count: int = 60, seed: int = 1, stretch: Sequence[int] | None = None,
    capture: Sequence[int] | None = None, truth: Floats = TRUTH, noise: float = 0.1,
) -> Rows:  # fmt: skip
    """Rows of a known motor, of columns of very unlike sizes."""
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((count, 4)) * SCALES
    drive = matrix @ truth + noise * rng.standard_normal(count)
    ones = np.ones(count)
    return Rows(
        matrix, drive, ones, np.arange(float(count)),
        np.arange(count) // 5 if stretch is None else np.array(stretch),
        np.zeros(count, dtype=np.int64) if capture is None else np.array(capture),
        np.zeros((count, 3)), np.zeros(count),
    )  # fmt: skip


def jackknife(given: Rows, labels: NDArray[np.int64], free: NDArray[np.bool_]) -> Floats:
    """(4, 4), by fits that leave out one block each."""
    found = []
    for label in np.unique(labels):
        kept = labels != label
        found.append(np.linalg.lstsq(given.matrix[kept][:, free], given.drive[kept], rcond=None)[0])
    apart = np.array(found) - np.mean(found, axis=0)
    out = np.zeros((4, 4))
    n = len(found)
    out[np.ix_(free, free)] = (n - 1) / n * apart.T @ apart
    return out


def test_coefficients_are_the_least_squares_and_their_covariance_the_jackknifes() -> None:
    given = rows()
    one = module.solve(given, ALL, np.zeros(4), 0.05)
    expected = np.linalg.lstsq(given.matrix, given.drive, rcond=None)[0]
    np.testing.assert_allclose(one.coefficients, expected, rtol=1e-9)
    np.testing.assert_allclose(one.covariance, jackknife(given, given.stretch, ALL), rtol=1e-6)
    np.testing.assert_allclose(one.residual, given.drive - given.matrix @ expected, atol=1e-12)
    assert one.sigma == pytest.approx(np.sqrt(np.diag(one.covariance)))
    assert (one.freedom, one.half_width_s) == (11, 0.05)  # twelve stretches
    assert (one.free.tolist(), one.at_bound.tolist()) == ([True] * 4, [False] * 4)


def test_what_is_known_stays_and_has_no_uncertainty() -> None:
    given, free = rows(), np.array([True, True, True, False])
    one = module.solve(given, free, np.array([9.0, 9.0, 9.0, -1.0]), 0.05)
    left = replace(given, drive=given.drive + given.matrix[:, 3])
    expected = np.linalg.lstsq(given.matrix[:, :3], left.drive, rcond=None)[0]
    assert one.coefficients == pytest.approx([*expected, -1.0])
    np.testing.assert_allclose(one.covariance, jackknife(left, given.stretch, free), rtol=1e-6)
    assert one.residual == pytest.approx(left.drive - given.matrix[:, :3] @ expected)


@pytest.mark.parametrize(("friction", "name"), [(1, "viscous"), (2, "coulomb")])
def test_a_friction_that_would_drive_is_nothing_and_as_unsure_as_without_its_bound(
    friction: int, name: str
) -> None:
    truth = TRUTH.copy()
    truth[friction] = -0.3 / SCALES[friction]
    given = rows(truth=truth)
    one = module.solve(given, ALL, np.full(4, 7.0), 0.05)
    assert module.COLUMNS[friction] == name
    assert one.coefficients[friction] == 0.0
    assert one.at_bound.tolist() == [k == friction for k in range(4)]
    assert one.free.tolist() == [k != friction for k in range(4)]
    others = [k for k in range(4) if k != friction]
    expected = np.linalg.lstsq(given.matrix[:, others], given.drive, rcond=None)[0]
    assert one.coefficients[others] == pytest.approx(expected)
    unbounded = jackknife(given, given.stretch, ALL)[friction, friction]
    assert one.covariance[friction, friction] == pytest.approx(unbounded)
    assert not one.covariance[friction, others].any()


def test_the_friction_that_is_farther_below_nothing_is_held_first() -> None:
    """The viscous one is below by .01 ± .004; without the other it is above."""
    rng = np.random.default_rng(4)
    speed = 1.0 + 0.05 * rng.standard_normal(60)
    matrix = np.column_stack([rng.standard_normal(60), speed, np.ones(60), np.zeros(60)])
    drive = matrix @ [1.0, 3.0, -2.0, 0.0] + 1e-3 * rng.standard_normal(60)
    given = replace(rows(), matrix=matrix, drive=drive)
    one = module.solve(given, np.array([True, True, True, False]), np.zeros(4), 0.05)
    assert one.at_bound.tolist() == [False, False, True, False]
    assert one.coefficients[1] == pytest.approx(1.0, abs=0.05)
    both = replace(given, drive=matrix @ [1.0, -0.5, -2.0, 0.0])
    held = module.solve(both, np.array([True, True, True, False]), np.zeros(4), 0.05)
    assert held.coefficients == pytest.approx([held.coefficients[0], 0.0, 0.0, 0.0])
    assert held.at_bound.tolist() == [False, True, True, False]


def test_an_inertia_and_an_offset_may_be_below_nothing() -> None:
    one = module.solve(rows(truth=np.array([-2.0, 0.5, 3.0, -1.0])), ALL, np.zeros(4), 0.05)
    assert one.coefficients[[0, 3]] == pytest.approx([-2.0, -1.0], abs=0.1)
    assert not one.at_bound.any()


@pytest.mark.parametrize(("runs", "widened"), [(2, False), (3, True)])
def test_three_runs_that_differ_widen_what_stretches_find_too_narrow(
    runs: int, widened: bool
) -> None:
    number = np.arange(60) * runs // 60
    given = rows(capture=number.tolist(), noise=1e-3)
    given = replace(given, drive=given.drive + 0.3 * given.matrix[:, 2] * number)
    one = module.solve(given, ALL, np.zeros(4), 0.05)
    alone = jackknife(given, given.stretch, ALL)
    between = jackknife(given, given.capture, ALL)
    if not widened:
        np.testing.assert_allclose(one.covariance, alone, rtol=1e-5)
        return
    expected = np.maximum(np.diag(alone), np.diag(between))
    assert (expected > np.diag(alone)).any()
    assert np.diag(one.covariance) == pytest.approx(expected)
    rho = one.covariance / np.outer(one.sigma, one.sigma)
    before = alone / np.sqrt(np.outer(np.diag(alone), np.diag(alone)))
    np.testing.assert_allclose(rho, before, atol=1e-6)  # widened, no more correlated


def test_a_variance_that_is_nothing_stays_nothing() -> None:
    mine, theirs = np.diag([4.0, 0.0, 1.0, 9.0]), np.diag([16.0, 5.0, 0.5, 0.0])
    assert module.at_least(mine, theirs).tolist() == np.diag([16.0, 0.0, 1.0, 9.0]).tolist()


def test_few_stretches_are_cut_in_halves_the_longest_first() -> None:
    def sizes(*lengths: int) -> list[int]:
        stretch = np.repeat(np.arange(len(lengths)), lengths)
        labels = blocks(rows(len(stretch), stretch=stretch.tolist()))
        joined = [set(labels[stretch == k].tolist()) for k in range(len(lengths))]
        assert sum(map(len, joined)) == len(set(labels.tolist()))  # none reaches over two
        return sorted(np.bincount(labels).tolist())

    assert sizes(96) == [6] * 8 + [12] * 4
    assert sizes(40, 8) == [4] * 2 + [5] * 8  # pieces of fewer than eight are not cut
    assert sizes(7) == [7]  # too short to be cut
    assert sizes(8) == [4, 4]
    assert sizes(*[5] * 12) == [5] * 12
    assert sizes(*[9] * 11) == [4, 5] + [9] * 10
    assert sizes(*[3] * 48) == [3] * 48


def test_many_stretches_are_joined_with_their_neighbours() -> None:
    stretch = np.repeat(np.arange(100) * 7, 2)
    labels = blocks(rows(200, stretch=stretch.tolist()))
    assert np.unique(labels).tolist() == list(range(48))
    assert (np.diff(labels) >= 0).all()
    assert set(np.bincount(labels).tolist()) == {4, 6}


def made(
    coefficients: Floats, variances: Floats, freedom: int = 20, bound: int | None = None
) -> Regression:
    free, at_bound = ALL.copy(), ~ALL
    if bound is not None:
        free[bound], at_bound[bound] = False, True
    given = rows()
    return Regression(
        coefficients, np.diag(variances), free, at_bound, given.drive, freedom, 0.0, given
    )


def test_the_width_of_the_least_product_of_uncertainties_is_taken() -> None:
    """And what half and double of it give otherwise is counted in."""
    found = {
        1.0: made(TRUTH + np.array([0.3, 0.0, 0.0, 0.0]), np.array([4.0, 1.0, 1.0, 1.0])),
        2.0: made(TRUTH, np.array([1.0, 1.0, 1.0, 1.5]), bound=2),
        4.0: made(TRUTH + np.array([0.0, 0.1, 5.0, 0.0]), np.array([2.0, 1.0, 1.0, 1.0])),
        8.0: made(TRUTH + np.array([9.0, 9.0, 9.0, 9.0]), np.array([9.0, 9.0, 9.0, 9.0])),
    }
    best = choose_width([4.0, 8.0, 1.0, 2.0], found.get)
    assert best is not None
    assert best.coefficients.tolist() == TRUTH.tolist()
    extra = best.covariance - np.diag([1.0, 1.0, 1.0, 1.5])
    expected = np.zeros((4, 4))
    expected[0, 0], expected[1, 1] = 0.3**2 / 2.0, 0.1**2 / 2.0  # none of what is at its bound
    np.testing.assert_allclose(extra, expected, atol=1e-12)


@pytest.mark.parametrize(("freedom", "fair"), [(10, True), (9, False)])
def test_a_width_with_few_blocks_knows_too_little_of_itself(freedom: int, fair: bool) -> None:
    found = {1.0: made(TRUTH, np.ones(4)), 2.0: made(TRUTH, 0.1 * np.ones(4), freedom)}
    best = choose_width([1.0, 2.0], found.get)
    assert best is not None
    assert (best.freedom == freedom) is fair


def test_a_single_width_has_no_neighbours() -> None:
    only = made(TRUTH, np.ones(4))
    best = choose_width([1.0, 2.0], {2.0: only}.get)
    assert best is not None
    np.testing.assert_array_equal(best.covariance, only.covariance)
    assert choose_width([1.0, 2.0], lambda _: None) is None


def test_a_column_without_an_entry_is_nothing_and_takes_nothing() -> None:
    given = rows()
    matrix = given.matrix.copy()
    matrix[:, 3] = 0.0
    one = module.solve(replace(given, matrix=matrix), ALL, np.zeros(4), 0.05)
    expected = np.linalg.lstsq(matrix[:, :3], given.drive, rcond=None)[0]
    assert one.coefficients == pytest.approx([*expected, 0.0])
    assert np.isfinite(one.covariance).all()


def test_runs_may_be_counted_from_one() -> None:
    given = rows(capture=1 + np.arange(60) // 20)
    found = module._between_runs(given, ALL, np.zeros(4))
    np.testing.assert_allclose(found, jackknife(given, given.capture, ALL), rtol=1e-6)


def test_two_blocks_leave_one_degree_of_freedom() -> None:
    """Of six rows, too few to be cut."""
    given = rows(6, stretch=[0, 0, 0, 1, 1, 1])
    free = np.array([True, False, False, False])
    assert module.solve(given, free, np.zeros(4), 0.05).freedom == 1


def test_the_movement_to_a_single_other_width_is_added_whole() -> None:
    one = module.solve(rows(), ALL, np.zeros(4), 0.05)
    moved = np.array([0.3, -0.1, 0.2, 0.4])
    other = replace(
        one, coefficients=one.coefficients + moved, covariance=4.0 * one.covariance,
        half_width_s=0.1,
    )  # fmt: skip
    chosen = choose_width((0.05, 0.1), {0.05: one, 0.1: other}.__getitem__)
    assert chosen is not None
    assert chosen.coefficients is one.coefficients
    assert chosen.covariance == pytest.approx(one.covariance + np.outer(moved, moved))


def test_where_it_is_asked_for_movement_counts_in_the_choice_of_width() -> None:
    """The best known is far from both neighbours; the next agrees with its own."""
    one = module.solve(rows(), ALL, np.zeros(4), 0.05)
    places = {1.0: 0.0, 2.0: 1.0, 4.0: 1.0, 8.0: 1.0}
    sizes = {1.0: 1.0, 2.0: 0.9, 4.0: 1.0, 8.0: 2.0}
    found = {
        h: replace(one, coefficients=np.full(4, 100.0 * places[h]), half_width_s=h,
                   covariance=np.diag([sizes[h] ** 2] * 4)) for h in places
    }  # fmt: skip
    usual, settled = (choose_width(list(found), found.get, asked) for asked in (False, True))
    assert usual is not None
    assert settled is not None
    assert (usual.half_width_s, settled.half_width_s) == (2.0, 4.0)
    assert np.diag(settled.covariance) == pytest.approx([1.0] * 4)


def test_further_terms_do_not_choose_the_width() -> None:
    given = rows()
    wide = replace(given, matrix=np.column_stack([given.matrix, given.late]))
    one = module.solve(wide, np.ones(5, dtype=bool), np.zeros(5), 0.05)
    assert one.covariance.shape == (5, 5)
    sharp, vague = (replace(one, covariance=np.diag([1.0, 1.0, 1.0, 1.0, last]), half_width_s=last)
                    for last in (1.0, 1e6))  # fmt: skip
    assert module._log_uncertainty(sharp) == module._log_uncertainty(vague) == 0.0
