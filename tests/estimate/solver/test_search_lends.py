"""What a search gives to another and to its caller: derivatives elsewhere, counts, a solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.errors import DataError
from motorid.estimate.solver.concentrated_likelihood import Concentrated
from motorid.estimate.solver.levenberg_marquardt import _lent, _straightened, maximise
from motorid.estimate.solver.normal_equations import Normal, products
from motorid.estimate.solver.problem import Block, Derivatives, Unknown, bounded_inverse
from motorid.estimate.solver.schur_complement import Eliminated
from tests.estimate.solutions import OneByOne

T = np.linspace(0.0, 1.0, 30)


class Plane(OneByOne):
    """y = a t + b t² + Σ c[k] t^(3 + k), in two blocks; counts what it is asked."""

    simulated = 0

    def __init__(self, *own: Unknown, seed: int = 1) -> None:
        self.y = 2.0 * T + 0.5 * T**2 + 0.1 * np.random.default_rng(seed).standard_normal(30)
        self.unknowns = own
        self.blocks: tuple[Block, ...] = (Block("early", 1e-9, 20), Block("late", 1e-9, 10))

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        self.simulated += 1
        left = self.y - shared[0] * T - shared[1] * T**2
        for k, c in enumerate(own):
            left = left - c * T ** (3 + k)
        return [left[:20], left[20:]]


class Silent(Plane):
    """A record without a reading."""

    blocks = ()

    def __init__(self) -> None:
        self.unknowns = ()

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        return []


FREE = (Unknown("a", 1.0), Unknown("b", 0.1))
LOGS = (Unknown("a", 1.0, log=True), Unknown("b", 0.1, log=True))
C, D = Unknown("c", 0.3, log=True, prior_mean=-1.0, prior_sd=0.5), Unknown("d", -0.2)


def test_work_and_width_are_those_of_the_widest_record() -> None:
    records = [Plane(C, D), Plane(), Plane(D)]
    engine = Concentrated(FREE, records)
    for record, responses in zip(records, (7, 3, 5), strict=True):
        record.simulated = responses
    assert engine.worked == 7
    assert engine.width == 1 + 2 + 2
    engine.derivatives(engine.start)
    assert engine.evaluations == 1 + 2 + 2
    assert Concentrated(FREE, []).worked == 0
    assert Concentrated(FREE, []).width == 1 + 2


@pytest.mark.parametrize(("count", "worth"), [(2.0, 2.0), (1.5, 1.5), (0.5, 1.0), (0.0, 1.0)])
def test_no_kind_of_reading_is_worth_less_than_one_where_its_noise_is_told(
    count: float, worth: float
) -> None:
    one = Plane()
    one.blocks = (Block("early", 1e-9, count), Block("late", 1e-9, 10))
    at = Concentrated(FREE, [one]).start
    assert at.variances[0] == pytest.approx(at.totals[0] / worth)


def test_a_record_without_readings_tells_nothing() -> None:
    engine = Concentrated(FREE, [Silent(), Plane()])
    known = engine.derivatives(engine.start)
    assert known.shared[0].shape == (2, 0)
    assert engine.weighed_residual(engine.start, 0).shape == (0,)
    both = maximise(FREE, [Silent(), Plane()])
    assert both.values == pytest.approx(maximise(FREE, [Plane()]).values)


@pytest.mark.parametrize("shared", [FREE, LOGS])
def test_derivatives_of_elsewhere_grow_as_the_logarithm_says(shared: tuple[Unknown, ...]) -> None:
    """The model is linear in its values: grown, they are those of the place itself."""
    engine = Concentrated(shared, [Plane(C, D), Plane(D, seed=2)])
    there = engine.derivatives(engine.start)
    own = [engine.start.own[0] + np.array([0.7, 0.2]), engine.start.own[1] - 0.3]
    at = engine.point(engine.start.shared + np.array([0.4, -0.9]), own)
    here = engine.derivatives(at)
    for k in (0, 1):
        for grown, taken in zip(
            engine.weighed_slopes(at, there, k), engine.weighed_slopes(at, here, k), strict=True
        ):
            np.testing.assert_allclose(grown, taken, rtol=1e-4, atol=1e-4)
        old, new = engine.normals(at, there)[k], engine.normals(at, here)[k]
        for name in ("ss", "so", "oo", "gs", "go"):
            np.testing.assert_allclose(getattr(old, name), getattr(new, name), rtol=1e-4, atol=1e-2)


def test_a_derivative_beyond_all_numbers_is_refused() -> None:
    engine = Concentrated(FREE, [Plane(), Plane(seed=2)])
    known = engine.derivatives(engine.start)
    broken = replace(known, shared=(np.full((2, 30), np.inf), known.shared[1]))
    with pytest.raises(DataError, match="finite parameters"):
        engine.normals(engine.start, broken)


@pytest.mark.parametrize("part", ["ss", "so", "oo", "gs", "go"])
def test_normal_equations_are_finite_where_all_of_them_are(part: str) -> None:
    whole = Normal(*(np.ones(1) for _ in range(5)))
    assert whole.finite
    assert not replace(whole, **{part: np.array([np.nan])}).finite


def test_products_are_those_of_each_block() -> None:
    rng = np.random.default_rng(1)
    A, C = rng.normal(size=(2, 9)), rng.normal(size=(3, 9))
    found = products(A, C, (4, 5))
    for k, here in enumerate((slice(0, 4), slice(4, 9))):
        np.testing.assert_allclose(found.ss[k], A[:, here] @ A[:, here].T)
        np.testing.assert_allclose(found.so[k], A[:, here] @ C[:, here].T)
        np.testing.assert_allclose(found.oo[k], C[:, here] @ C[:, here].T)


def test_an_idle_nuisance_has_its_derivative_taken_anew_and_counted() -> None:
    """Two records, of which one has two idle nuisances and the other none."""
    before = maximise(FREE, [Plane(D, D), Plane(D)], max_iterations=0)
    assert before.derivatives is not None
    slopes = before.derivatives.own_slopes
    idle = replace(before.derivatives, own_slopes=(np.zeros_like(slopes[0]), slopes[1]))
    engine = Concentrated(FREE, [Plane(D, D), Plane(D)], replace(before, derivatives=idle))
    assert engine.known is not None
    for anew, wanted in zip(engine.known.own_slopes, slopes, strict=True):
        np.testing.assert_allclose(anew, wanted, atol=1e-6)
    assert engine.evaluations == before.evaluations + 1 + 2


@pytest.mark.parametrize(
    ("unknown", "value", "log"),
    [
        (Unknown("B", 1.0, lower=0.0), 0.5, True),
        (Unknown("B", 1.0, lower=0.0), 0.0, False),  # it has no logarithm
        (Unknown("B", 1.0, lower=-1.0), 0.5, False),
        (Unknown("B", 1.0, lower=0.0, prior_sd=2.0), 0.5, False),  # the prior is of the value
        (Unknown("B", 1.0, lower=-1.0, log=True), 0.5, True),
        (Unknown("B", 1.0, lower=0.0, log=True, prior_sd=2.0), 0.5, True),
    ],
)
def test_what_is_positive_can_be_searched_by_its_logarithm(
    unknown: Unknown, value: float, log: bool
) -> None:
    found = _straightened(unknown, value)
    assert found.log is log
    assert found == replace(unknown, start=value, log=log)


def test_derivatives_are_lent_in_the_other_search_s_coordinates() -> None:
    one, other = Concentrated(FREE, [Plane(D)]), Concentrated(LOGS, [Plane(D)])
    assert _lent(one, other) is None
    one.known = one.derivatives(one.start)
    lent, wanted = _lent(one, other), other.derivatives(other.start)
    assert isinstance(lent, Derivatives)
    assert lent.at == pytest.approx(np.log([1.0, 0.1]))
    np.testing.assert_allclose(lent.shared[0], wanted.shared[0], rtol=1e-4, atol=1e-5)
    other.known = wanted
    back = _lent(other, one)
    assert isinstance(back, Derivatives)
    np.testing.assert_allclose(back.shared[0], one.known.shared[0], rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("value", [0.0, -0.1])
def test_derivatives_taken_where_there_is_no_logarithm_are_not_lent(value: float) -> None:
    one, other = Concentrated(FREE, [Plane()]), Concentrated(LOGS, [Plane()])
    one.known = one.derivatives(one.point(np.array([1.0, value]), [np.zeros(0)]))
    assert _lent(one, other) is None


class Bent(Plane):
    """a / b is known far better than a: the valley of equal a / b is curved."""

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        self.simulated += 1
        return [np.full(20, 2.0 - shared[0] / shared[1]), np.full(10, 3.0 - shared[0])]


@pytest.mark.parametrize("rounds", [1, 3, 100])
def test_every_response_of_both_coordinates_is_counted(rounds: int) -> None:
    record = Bent()
    record.blocks = (Block("ratio", 1e-6, 20), Block("a", 1e-3, 10))
    start = (Unknown("a", 3.15, log=True), Unknown("b", 1.575, lower=0.0))
    solution = maximise(start, [record], max_iterations=rounds)
    assert solution.evaluations == record.simulated


@pytest.mark.parametrize("shared", [FREE, (FREE[0], replace(FREE[1], lower=0.0))])
def test_what_ends_by_itself_is_searched_once(shared: tuple[Unknown, ...]) -> None:
    """A start, a slope of each, and steps on straight ground; one of which may be cut short."""
    assert maximise(shared, [Plane()]).evaluations <= 1 + 2 + 8
    cut = maximise(FREE, [Plane()], max_iterations=1)
    assert not cut.converged
    assert cut.evaluations <= 1 + 2 + 1 + 2


def test_the_solution_names_rows_and_bounds() -> None:
    shared = (Unknown("a", 1.0, upper=1.5), Unknown("b", 0.1))
    solution = maximise(shared, [Plane(C)])
    (line,) = solution.records
    assert solution.at_bound.tolist() == [True, False]
    assert solution.values[0] == 1.5
    assert line.slices == (slice(0, 20), slice(20, 30))
    cube = np.repeat(1.0 / line.sigmas, [20, 10]) * T**3 * solution.own[0][0]
    assert line.own_information[0, 0] == pytest.approx(float(cube @ cube) + 0.5**-2, rel=1e-4)


def test_information_beside_nuisances_that_are_nearly_alike_keeps_its_digits() -> None:
    """Against the part of t that is orthogonal to the nuisances' columns, by QR."""

    class Twins(Plane):
        def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
            left = self.y - shared[0] * T - own[0] - own[1] * (1.0 + 1e-5 * T**2)
            return [left[:20], left[20:]]

    one = Twins(Unknown("c", 0.1), Unknown("d", 0.1))
    one.blocks = (Block("early", 1.0, 20, "y"), Block("late", 1.0, 10, "y"))
    solution = maximise((Unknown("a", 2.0),), [one], max_iterations=0)
    basis = np.linalg.qr(np.column_stack([np.ones(30), T**2]))[0]
    left = T - basis @ (basis.T @ T)
    assert solution.information[0, 0] == pytest.approx(float(left @ left), rel=1e-3)


@pytest.mark.parametrize(
    ("information", "inverse"),
    [
        ([[4.0, 0.0], [0.0, 0.0]], [[0.25, 0.0], [0.0, 0.0]]),  # nothing is known of the second
        ([[-1e-20]], [[0.0]]),  # less than nothing, by rounding
        ([[4.0, 6.2], [6.2, 9.0]], [[1 / 16, 1 / 24], [1 / 24, 1 / 36]]),  # as if it were 6
        ([[4.0, -6.2], [-6.2, 9.0]], [[1 / 16, -1 / 24], [-1 / 24, 1 / 36]]),
    ],
)
def test_information_that_rounding_spoilt_has_an_inverse(
    information: list[list[float]], inverse: list[list[float]]
) -> None:
    found = bounded_inverse(np.array(information), np.zeros(len(information), dtype=bool))
    np.testing.assert_allclose(found, inverse, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("left", "alone", "doubtful"),
    [(1.1e-5, 0.9e8, False), (0.9e-5, 0.9e8, True), (1.1e-5, 2e8, True)],
)
def test_a_millionth_left_and_a_variance_by_a_hundred_million_are_doubtful(
    left: float, alone: float, doubtful: bool
) -> None:
    """Of an information of 10, and of nuisances whose information is 4."""
    normal = Normal(np.array([[10.0]]), np.ones((1, 1)), np.array([[4.0]]), np.ones(1), np.ones(1))
    found = Eliminated(np.array([[left]]), np.ones((1, 1)), np.array([[alone / 4.0]]))
    assert found.doubtful(normal) is doubtful
