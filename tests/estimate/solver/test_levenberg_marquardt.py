"""The engine on problems whose answer is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.solver.levenberg_marquardt import maximise
from motorid.estimate.solver.problem import Block, Unknown
from motorid.estimate.solver.search_coordinates import Coordinates
from tests.estimate.solutions import OneByOne

STEPS = 8  # of a search on straight ground, whose damping falls from step to step


class Noise:
    """White noise that begins anew with every test, whichever ran before."""

    rng = np.random.default_rng(20)


@pytest.fixture(autouse=True)
def same_noise() -> None:
    Noise.rng = np.random.default_rng(20)


class Line(OneByOne):
    """y = a x + b x² + c, with c the record's own; one block, or x split in two."""

    simulated = 0

    def __init__(
        self, n: int, c: float, sd: float = 0.1, prior_sd: float = np.inf, group: str = ""
    ) -> None:
        self.x = np.linspace(-1, 2, n)
        self.y = 2.0 * self.x + 0.5 * self.x**2 + c + sd * Noise.rng.standard_normal(n)
        self.unknowns = (Unknown("c", 0.0, prior_sd=prior_sd),)
        self.blocks = (Block("y", 1e-9, n, group),)

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        a, b = shared
        return [self.y - a * self.x - b * self.x**2 - own[0]]


SHARED = (Unknown("a", 1.0, log=True), Unknown("b", 0.1, lower=0.0))


def test_agrees_with_linear_least_squares_and_its_covariance() -> None:
    record = Line(400, 3.0)
    solution = maximise(SHARED, [record])
    columns = np.stack([record.x, record.x**2, np.ones(400)], axis=1)
    expected, squares, *_ = np.linalg.lstsq(columns, record.y, rcond=None)
    np.testing.assert_allclose(solution.values, expected[:2], rtol=1e-6)
    np.testing.assert_allclose(solution.own[0], expected[2:], rtol=1e-6)
    covariance = np.linalg.inv(columns.T @ columns) * squares[0] / 400
    found = solution.covariance * np.outer(solution.slopes, solution.slopes)
    np.testing.assert_allclose(found, covariance[:2, :2], rtol=1e-4)
    np.testing.assert_allclose(solution.own_covariance[0], covariance[2:, 2:], rtol=1e-4)
    assert solution.converged
    assert solution.chi_square == pytest.approx(400, rel=1e-6)
    assert solution.degrees_of_freedom == 397


def test_captures_share_parameters_and_keep_their_nuisances_and_noise() -> None:
    records = [Line(300, 1.0, 0.05), Line(300, -4.0, 0.5)]
    solution = maximise(SHARED, records)
    weights = [1 / r.sigmas[0] for r in solution.records]
    rows, right = [], []
    for k, (record, w) in enumerate(zip(records, weights, strict=True)):
        own = np.zeros((300, 2))
        own[:, k] = 1.0
        rows.append(w * np.column_stack([record.x, record.x**2, own]))
        right.append(w * record.y)
    expected = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    np.testing.assert_allclose(solution.values, expected[:2], rtol=1e-5)
    np.testing.assert_allclose([o[0] for o in solution.own], expected[2:], rtol=1e-5)
    assert weights[0] / weights[1] == pytest.approx(10, rel=0.15)


def test_blocks_of_one_group_share_their_noise() -> None:
    records = [Line(300, 0.0, 0.3, group="y"), Line(300, 0.0, 0.4, group="y")]
    solution = maximise(SHARED, records)
    assert solution.records[0].sigmas == solution.records[1].sigmas
    assert solution.records[0].sigmas[0] == pytest.approx(np.hypot(0.3, 0.4) / np.sqrt(2), rel=0.1)


def test_a_bound_holds_and_is_said() -> None:
    record = Line(200, 0.0)
    record.y = record.y - 1.5 * record.x**2
    solution = maximise(SHARED, [record])
    assert solution.values[1] == 0.0
    assert solution.at_bound.tolist() == [False, True]
    assert solution.covariance[1, 1] == 0.0


def test_a_prior_pulls_as_much_as_its_width_says() -> None:
    record = Line(50, 1.0, sd=0.1, prior_sd=1e-6)
    solution = maximise(SHARED, [record])
    assert abs(solution.own[0][0]) < 1e-6


def test_a_floor_keeps_a_block_from_being_trusted_too_much() -> None:
    record = Line(100, 0.0, sd=1e-4)
    record.blocks = (Block("y", 0.1, 100),)
    solution = maximise(SHARED, [record])
    assert solution.records[0].sigmas[0] == 0.1
    assert solution.chi_square < 1e-3


def test_a_start_far_away_still_arrives() -> None:
    record = Line(300, 3.0)
    far = maximise((Unknown("a", 0.05, log=True), Unknown("b", 10.0, lower=0.0)), [record])
    near = maximise(SHARED, [record])
    np.testing.assert_allclose(far.values, near.values, rtol=1e-4)


class Valley(OneByOne):
    """a / b is known far better than a: in b itself, the valley of equal a / b is curved."""

    unknowns, simulated = (), 0
    blocks = (Block("ratio", 1e-6, 20), Block("a", 1e-3, 20))

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        a, b = shared
        return [np.full(20, 2.0 - a / b), np.full(20, 3.0 - a)]


def test_a_search_that_stops_short_says_what_is_left_of_it() -> None:
    """Its quadratic model, near the minimum, and the step to there in search coordinates."""
    record = Line(300, 0.0)
    ended = maximise(SHARED, [record])
    assert (ended.left, ended.promised, ended.unfinished) == (None, 0.0, False)
    shift = np.sqrt(np.diag(ended.covariance))
    begun = [replace(u, start=float(v)) for u, v in zip(SHARED, ended.values, strict=True)]
    off = Coordinates(begun).outward(Coordinates(begun).start + shift)
    short = maximise(
        [replace(u, start=float(v)) for u, v in zip(begun, off, strict=True)], [record], 0
    )
    assert short.left == pytest.approx(-shift, rel=0.1)
    assert short.promised == pytest.approx(short.objective - ended.objective, rel=0.1)
    assert short.unfinished
    assert not replace(short, promised=0.9).unfinished
    assert replace(short, promised=np.inf).unfinished


def test_a_curved_valley_is_walked_to_its_end() -> None:
    start = (Unknown("a", 3.15, log=True), Unknown("b", 1.575, lower=0.0))
    solution = maximise(start, [Valley()])
    np.testing.assert_allclose(solution.values, [3.0, 1.5], rtol=1e-6)
    assert solution.converged


def test_a_value_far_above_its_scale_keeps_a_step_that_rounding_leaves_alone() -> None:
    frame = Coordinates([Unknown("B", 1.0, lower=0.0, scale=1e-12)])
    assert frame.difference(frame.start, 0) == pytest.approx(1e-6)


class Dear(Line):
    """A line far from straight, each response of which is worth many."""

    worth = 1

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        self.simulated += self.worth
        return super().residuals(np.exp(shared), own)


def test_a_search_of_dear_responses_ends_by_what_they_are_worth() -> None:
    cheap, dear = Dear(300, 3.0), Dear(300, 3.0)
    dear.worth = 300
    far = (Unknown("a", 6.0), Unknown("b", -6.0))
    whole, cut = maximise(far, [cheap]), maximise(far, [dear])
    assert whole.converged
    assert not cut.converged
    assert cut.evaluations < whole.evaluations


@pytest.mark.parametrize(("enough", "own_place"), [(1e-6, True), (1e-3, False)])
def test_the_end_of_a_fine_search_has_derivatives_of_its_own_place(enough, own_place) -> None:
    record, near = Dear(300, 3.0), (Unknown("a", 0.692), Unknown("b", -0.68))
    before = maximise(near, [record], max_iterations=0)
    found = maximise(near, [record], enough=enough, before=before)
    apart = float(np.abs(found.derivatives.at - found.values).max())
    assert found.converged
    assert (apart < 1e-6) == own_place


class Exchanged(Line):
    """A line whose offset is a parameter's as much as the record's own, which a prior knows."""

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        a, d = shared
        return [self.y - 0.5 * self.x**2 - a * self.x - d - own[0]]


def test_derivatives_serve_while_a_prior_is_what_gives_way() -> None:
    record = Exchanged(400, 3.0)
    record.unknowns = (Unknown("c", 0.0, prior_mean=2.0, prior_sd=0.1),)
    solution = maximise((Unknown("a", 1.0), Unknown("d", 3.0)), [record])
    assert solution.converged
    assert solution.own[0][0] == pytest.approx(2.0, abs=1e-3)
    assert solution.evaluations <= 1 + 3 + STEPS  # derivatives are taken once: all is straight


class Switched(Line):
    """A line whose offset shows from some moment on, as a loss does once its current is known."""

    shows = False

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        return super().residuals(shared, own if self.shows else np.zeros(1))


def test_lent_derivatives_are_taken_anew_of_a_nuisance_that_moved_nothing() -> None:
    record = Switched(400, 0.1)
    before = maximise(SHARED, [record])
    record.shows = True
    lent = maximise(SHARED, [record], enough=1.0, before=before)
    alone = maximise(SHARED, [record])
    assert before.own[0][0] == 0.0
    assert lent.own[0][0] == pytest.approx(alone.own[0][0], abs=0.002)
    assert lent.evaluations - before.evaluations < alone.evaluations


def test_a_nuisance_that_is_free_takes_its_part_of_every_derivative() -> None:
    (line,) = maximise(SHARED, [Line(200, 3.0)]).records
    free, information = line.cleared()
    assert line.held == ()
    np.testing.assert_allclose(free.T @ line.orthogonal, 0.0, atol=1e-9 * 200)
    np.testing.assert_allclose(information, line.own_information)


def test_a_nuisance_that_is_held_at_its_bound_follows_nothing() -> None:
    """The readings ask for c = -3, and c cannot be below 0."""
    record = Line(200, -3.0)
    record.unknowns = (Unknown("c", 0.0, lower=0.0),)
    solution = maximise(SHARED, [record])
    (line,) = solution.records
    assert solution.own[0][0] == 0.0
    assert line.held == (0,)
    assert np.any(line.own)
    free, information = line.cleared()
    assert not np.any(free)
    assert not np.any(information)
    np.testing.assert_allclose(line.orthogonal, line.shared)
