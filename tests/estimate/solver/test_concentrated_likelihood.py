"""Twice the negative log-likelihood of Gaussian readings whose noise is unknown, written out."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from motorid.errors import DataError
from motorid.estimate.solver.concentrated_likelihood import Concentrated
from motorid.estimate.solver.problem import Block, Unknown
from tests.estimate.solutions import OneByOne


class Straight(OneByOne):
    """y = a x + c, c its own, with what was known of c before."""

    simulated = 0

    def __init__(self, n: int, seed: int, group: str, prior_sd: float = np.inf) -> None:
        self.x = np.linspace(-1.0, 2.0, n)
        self.y = 2.0 * self.x + 0.3 + np.random.default_rng(seed).normal(0.0, 0.1, n)
        self.unknowns = (Unknown("c", 0.0, prior_sd=prior_sd),)
        self.blocks = (Block("y", 1e-9, n, group),)

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        return [self.y - shared[0] * self.x - own[0]]


A = (Unknown("a", 1.0),)


def minus_twice_log(residual: np.ndarray) -> float:
    """Of independent Gaussian residuals at their most likely deviation, less n ln 2π."""
    sd = float(np.sqrt(np.mean(residual**2)))
    whole = -2.0 * float(norm.logpdf(residual, 0.0, sd).sum())
    return whole - len(residual) * float(np.log(2 * np.pi))


@pytest.mark.parametrize(("a", "c"), [(1.0, 0.0), (2.0, 0.3), (-1.0, 5.0)])
def test_each_kind_of_reading_has_its_own_noise(a: float, c: float) -> None:
    records = [Straight(40, 1, ""), Straight(60, 2, "")]
    at = Concentrated(A, records).point(np.array([a]), [np.array([c])] * 2)
    expected = sum(minus_twice_log(r.y - a * r.x - c) for r in records)
    assert at.objective == pytest.approx(expected, rel=1e-9)


def test_one_group_has_one_noise() -> None:
    records = [Straight(40, 1, "y"), Straight(60, 2, "y")]
    at = Concentrated(A, records).point(np.array([1.5]), [np.array([0.1])] * 2)
    together = np.concatenate([r.y - 1.5 * r.x - 0.1 for r in records])
    assert at.objective == pytest.approx(minus_twice_log(together), rel=1e-9)


def test_what_was_known_before_adds_its_chi_square() -> None:
    vague, known = Straight(40, 1, ""), Straight(40, 1, "", prior_sd=0.2)
    points = [
        Concentrated(A, [one]).point(np.array([1.0]), [np.array([0.5])]) for one in (vague, known)
    ]
    assert points[1].objective - points[0].objective == pytest.approx((0.5 / 0.2) ** 2)
    assert points[1].prior == pytest.approx((0.5 / 0.2) ** 2)


def test_derivatives_of_a_straight_line_are_its_columns() -> None:
    one = Straight(40, 1, "")
    engine = Concentrated(A, [one])
    found = engine.derivatives(engine.start)
    assert np.abs(found.shared[0][0]) == pytest.approx(np.abs(one.x), abs=1e-6)
    assert np.abs(found.own_slopes[0][0]) == pytest.approx(np.ones(40), abs=1e-6)
    assert np.sign(found.shared[0][0][0]) == np.sign(-found.own_slopes[0][0][0])


def normal_equations(records: list[Straight], at: float, own: list[float]) -> np.ndarray:
    """Weighed least squares for a and each c, the noise held: a's and every c's moves."""
    rows, left = [], []
    for k, one in enumerate(records):
        r = one.y - at * one.x - own[k]
        sd = float(np.sqrt(np.mean(r**2)))
        columns = np.zeros((len(r), 1 + len(records)))
        columns[:, 0], columns[:, 1 + k] = one.x, 1.0
        rows.append(columns / sd)
        left.append(r / sd)
        prior = one.unknowns[0].prior_sd
        if np.isfinite(prior):
            line = np.zeros(1 + len(records))
            line[1 + k] = 1.0 / prior
            rows.append(line[None, :])
            left.append(np.array([-own[k] / prior]))
    return np.linalg.lstsq(np.concatenate(rows), np.concatenate(left), rcond=None)[0]


def test_a_step_without_damping_solves_the_weighed_least_squares() -> None:
    records = [Straight(40, 1, "", 0.2), Straight(60, 2, "")]
    engine = Concentrated(A, records)
    at = engine.point(np.array([1.2]), [np.array([0.4]), np.array([-0.1])])
    normals = engine.normals(at, engine.derivatives(at))
    shared, own, promise = engine.move(at, normals, 0.0)
    moves = normal_equations(records, 1.2, [0.4, -0.1])
    assert shared[0] - 1.2 == pytest.approx(moves[0], rel=1e-5)
    assert [x[0] for x in own] == pytest.approx([0.4 + moves[1], -0.1 + moves[2]], rel=1e-5)
    # of straight lines the promise is what chi-square falls by, by the noise of before
    reached = engine.point(shared, own)
    assert promise == pytest.approx(at.fallen_to(reached), rel=1e-5)
    assert promise > 0.0


def test_what_was_known_of_a_shared_one_pulls_it() -> None:
    """(y of weight n/s², prior of weight 1/sd²): their weighed mean."""
    shared = (Unknown("a", 1.0, prior_mean=0.5, prior_sd=0.01),)
    one = Straight(40, 1, "")
    engine = Concentrated(shared, [one])
    at = engine.point(np.array([1.0]), [np.array([0.3])])
    assert at.prior == pytest.approx(50.0**2)
    moved, own, promise = engine.move(at, engine.normals(at, engine.derivatives(at)), 0.0)
    sd = float(np.sqrt(np.mean((one.y - one.x - 0.3) ** 2)))
    known = np.array([[100.0, 0.0]])
    rows = np.vstack([np.column_stack([one.x, np.ones(40)]) / sd, known])
    left = np.append((one.y - one.x - 0.3) / sd, -0.5 * 100.0)
    wanted = np.linalg.lstsq(rows, left, rcond=None)[0]
    assert moved[0] - 1.0 == pytest.approx(wanted[0], rel=1e-5)
    assert promise == pytest.approx(at.fallen_to(engine.point(moved, own)), rel=1e-5)


def test_damping_shortens_a_step_and_its_promise() -> None:
    engine = Concentrated(A, [Straight(40, 1, "")])
    at = engine.point(np.array([1.0]), [np.array([0.0])])
    normals = engine.normals(at, engine.derivatives(at))
    lengths = [abs(engine.move(at, normals, d)[0][0] - 1.0) for d in (0.0, 0.1, 1.0, 10.0)]
    promises = [engine.move(at, normals, d)[2] for d in (0.0, 0.1, 1.0, 10.0)]
    assert lengths == sorted(lengths, reverse=True)
    assert promises == sorted(promises, reverse=True)
    assert promises[-1] > 0.0
    after, promise = engine.step(at, normals, 0.1)
    assert promise == promises[1]
    assert after.objective < at.objective


def test_no_residual_is_below_its_floor() -> None:
    one = Straight(40, 1, "")
    one.blocks = (Block("y", 5.0, 40, ""),)
    at = Concentrated(A, [one]).point(np.array([2.0]), [np.array([0.3])])
    left = one.y - 2.0 * one.x - 0.3
    assert at.sigmas[0] == pytest.approx([5.0])
    assert at.objective == pytest.approx(80 * np.log(5.0) + float(left @ left) / 25.0)


def test_readings_that_count_less_tell_a_larger_noise() -> None:
    one = Straight(40, 1, "")
    one.blocks = (Block("y", 1e-9, 10.0, ""),)
    at = Concentrated(A, [one]).point(np.array([1.0]), [np.array([0.3])])
    total = float(((one.y - one.x - 0.3) ** 2).sum())
    assert at.totals == pytest.approx([total])
    assert at.variances == pytest.approx([total / 10.0])
    assert at.objective == pytest.approx(10.0 * np.log(total / 10.0) + 10.0)


def test_of_one_group_the_highest_floor_holds() -> None:
    records = [Straight(40, 1, "y"), Straight(60, 2, "y")]
    records[0].blocks = (Block("y", 7.0, 40, "y"),)
    at = Concentrated(A, records).point(np.array([2.0]), [np.array([0.3])] * 2)
    assert [s.tolist() for s in at.sigmas] == [[7.0], [7.0]]


def test_weighed_residuals_and_slopes_are_over_the_noise() -> None:
    one = Straight(40, 1, "")
    engine = Concentrated(A, [one])
    at = engine.point(np.array([1.0]), [np.array([0.3])])
    left, sd = one.y - one.x - 0.3, at.sigmas[0][0]
    assert engine.weighed_residual(at, 0) == pytest.approx(left / sd)
    assert engine.weighed_residual(at, 0, 2) == pytest.approx(left / sd**2)
    shared, own = engine.weighed_slopes(at, engine.derivatives(at), 0)
    assert shared[0] == pytest.approx(one.x / sd, abs=1e-5)
    assert own[0] == pytest.approx(np.full(40, 1.0 / sd), rel=1e-5)


def test_each_response_is_counted_once() -> None:
    engine = Concentrated(A, [Straight(40, 1, ""), Straight(60, 2, "")])
    assert engine.evaluations == 1
    engine.derivatives(engine.start)
    assert engine.evaluations == 3  # a and c of the widest record


def test_derivatives_serve_near_where_they_were_taken() -> None:
    engine = Concentrated(A, [Straight(40, 1, "")])
    known = engine.derivatives(engine.start)
    assert engine.apart(engine.start, known) == 0.0
    moved = engine.point(engine.start.shared + 0.25, [np.array([-0.5])])
    assert engine.apart(moved, known) == pytest.approx(0.5)
    assert engine.fits(known)
    assert not Concentrated(A, [Straight(41, 1, "")]).fits(known)


def test_a_search_that_begins_beyond_all_numbers_is_refused() -> None:
    one = Straight(40, 1, "")
    one.y[3] = np.inf
    with pytest.raises(DataError, match="no motor with finite parameters"):
        Concentrated(A, [one])
