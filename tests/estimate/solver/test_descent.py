"""Which steps a search takes, by which damping and derivatives, where each step is told to it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from motorid.estimate.solver.concentrated_likelihood import Point
from motorid.estimate.solver.levenberg_marquardt import _descend, maximise
from motorid.estimate.solver.problem import Block, Derivatives, Unknown
from tests.estimate.solutions import OneByOne

HELPS = (1.0, 1.0, 1.0)  # what F falls by, chi-square falls by, and the step promised
FAILS = (-1.0, -1.0, 1.0)
ENDS = (0.0, 0.0, 0.0)


def point(objective: float, chi_square: float) -> Point:
    """Of one kind of reading, whose noise is 1."""
    sums = np.array([chi_square])
    return Point(np.zeros(1), [], [], sums, np.ones(1), [], 0.0, objective)


class Told:
    """A search whose every step does what it is told, and which notes what it is asked."""

    def __init__(
        self, *steps: tuple[float, float, float], far: float = 0.0, left: float = 0.0, cost: int = 0
    ) -> None:
        self.steps, self.far, self.left, self.cost = list(steps), far, left, cost
        self.known: Derivatives | None = None
        self.dampings: list[float] = []
        self.taken: list[int] = []  # how many steps had been tried when derivatives were taken
        self.worked, self.width, self.used_up = 5, 2, False

    def derivatives(self, at: Point) -> Derivatives:
        self.taken.append(len(self.dampings))
        return Derivatives(at.shared, (), (), ())

    def apart(self, at: Point, known: Derivatives) -> float:
        assert isinstance(known, Derivatives)
        return 0.0 if known.at is at.shared else self.far

    def normals(self, at: Point, known: Derivatives) -> list[object]:
        return []

    def step(self, at: Point, normals: Sequence[object], damping: float) -> tuple[Point, float]:
        self.dampings.append(damping)
        self.worked += self.cost
        gain, fallen, promise = self.steps[len(self.dampings) - 1]
        return point(at.objective - gain, float(at.totals[0]) - fallen), promise

    def move(
        self, at: Point, normals: Sequence[object], damping: float
    ) -> tuple[None, None, float]:
        assert damping == 0.0
        return None, None, self.left

    def lend(self, at: Point) -> None:
        """Derivatives of elsewhere."""
        self.known = Derivatives(at.shared.copy(), (), (), ())


def descend(search: Told, rounds: int = 50, enough: float = 0.5, **how: object):
    start = point(100.0, 100.0)
    if search.far:
        search.lend(start)
    return _descend(search, start, rounds, enough, **how)  # type: ignore[arg-type]


def test_each_step_that_helps_makes_the_damping_a_tenth() -> None:
    search = Told(*[HELPS] * 12, ENDS)
    at, converged, _ = descend(search)
    assert search.dampings == pytest.approx([10.0**-k for k in range(3, 12)] + [1e-12] * 4)
    assert converged
    assert at.objective == 88.0
    assert search.taken == [0]  # they kept their word
    assert search.known is not None


def test_damping_rises_eightfold_and_the_first_step_through_keeps_it() -> None:
    search = Told(FAILS, FAILS, HELPS, HELPS, ENDS)
    at, converged, _ = descend(search)
    assert search.dampings == pytest.approx([1e-3, 8e-3, 64e-3, 64e-3, 6.4e-3])
    assert converged
    assert at.objective == 98.0


def test_a_failure_by_old_derivatives_is_tried_again_with_new_ones() -> None:
    search = Told(HELPS, FAILS, HELPS, ENDS)
    descend(search)
    assert search.taken == [0, 2]
    assert search.dampings == pytest.approx([1e-3, 1e-4, 1e-4, 1e-5])


def test_one_that_is_not_patient_gives_up_at_a_failure_of_its_own_place() -> None:
    search = Told(HELPS, FAILS, FAILS, HELPS)
    at, converged, _ = descend(search, patient=False)
    assert len(search.dampings) == 3  # the second failure is that by new derivatives
    assert not converged
    assert at.objective == 99.0


@pytest.mark.parametrize(
    "last", [(0.4, 0.4, 0.4), (0.0, 0.0, 0.4), (-1.0, -1.0, 0.4), (-1.0, -1.0, 0.0)]
)
def test_a_search_ends_where_little_is_promised_and_little_won(
    last: tuple[float, float, float],
) -> None:
    search = Told(HELPS, last)
    at, converged, _ = descend(search)
    assert converged
    assert len(search.dampings) == 2
    assert at.objective == 99.0 - max(last[0], 0.0)
    assert at.shared is not search.known.at


def test_a_step_that_changes_nothing_is_taken() -> None:
    search = Told((0.0, 3.0, 0.4))
    at, _, _ = descend(search)
    assert at.totals.tolist() == [97.0]


@pytest.mark.parametrize(
    "step",
    [(2.0, 0.4, 0.4), (0.5, 0.4, 0.4), (0.4, 0.6, 0.6), (0.4, 0.5, 0.5), (-1.0, 0.0, -0.1)],
)
def test_it_goes_on_where_either_is_more(step: tuple[float, float, float]) -> None:
    """Or where less than nothing is promised, which rounding does not explain."""
    search = Told(step, ENDS)
    descend(search)
    assert len(search.dampings) == 2


def test_a_failure_under_much_damping_is_no_end() -> None:
    small = (-1.0, -1.0, 0.4)
    assert descend(Told(small), damping=0.9)[1]
    search = Told(small, small, HELPS, ENDS)
    assert descend(search, damping=1.0)[1]
    assert search.dampings == pytest.approx([1.0, 8.0, 64.0, 64.0])


@pytest.mark.parametrize(
    ("enough", "far", "anew"),
    [
        (1.0, 1e6, False),  # a rough answer serves with rough derivatives
        (1e-3, 0.01, False),
        (1e-3, 0.011, True),
        (2e-5, 0.01, False),
        (2e-5, 0.011, True),
        (1e-5, 1e-9, True),  # the end of a flat valley has its own
        (1e-7, 1e-9, True),
    ],
)
def test_lent_derivatives_serve_near_where_they_were_taken(
    enough: float, far: float, anew: bool
) -> None:
    search = Told(ENDS, ENDS, far=far)
    _, converged, _ = descend(search, enough=enough)
    assert converged
    assert search.taken == ([0] if anew else [])


@pytest.mark.parametrize("last", [(0.0, 0.0, 1e-5), (-1.0, -1.0, 1e-5)])
@pytest.mark.parametrize(("far", "anew"), [(0.0099, False), (0.01, False), (0.02, True)])
def test_what_was_left_behind_is_taken_anew_before_the_end(
    last: tuple[float, float, float], far: float, anew: bool
) -> None:
    search = Told(HELPS, last, ENDS)
    start = point(100.0, 100.0)
    search.far = far
    _, converged, _ = _descend(search, start, 50, 1e-3)  # type: ignore[arg-type]
    assert converged
    assert search.taken == ([0, 2] if anew else [0])


@pytest.mark.parametrize(
    ("fallen", "anew"), [(1.4, True), (1.5, False), (2.0, False), (2.5, False), (2.6, True)]
)
def test_derivatives_that_miss_a_quarter_of_their_promise_are_taken_anew(
    fallen: float, anew: bool
) -> None:
    search = Told((2.0, fallen, 2.0), ENDS)
    descend(search)
    assert search.taken == ([0, 1] if anew else [0])


@pytest.mark.parametrize(("damping", "tries"), [(1.25e11, 2), (2.5e11, 1), (1e9, 4)])
def test_no_step_helps_with_a_damping_beyond_all_reason(damping: float, tries: int) -> None:
    search = Told(*[FAILS] * 9, left=6.0)
    at, converged, _ = descend(search, damping=damping)
    assert len(search.dampings) == tries
    assert not converged
    assert at.objective == 100.0


def test_it_ends_with_its_rounds() -> None:
    search = Told(*[HELPS] * 9)
    at, converged, _ = descend(search, rounds=3)
    assert not converged
    assert at.objective == 97.0


@pytest.mark.parametrize(("cost", "tries"), [(12, 3), (13, 2), (1, 4)])
def test_it_ends_where_responses_took_thrice_what_all_rounds_do(cost: int, tries: int) -> None:
    """24 of four rounds by a width of two, besides those before it."""
    search = Told(*[HELPS] * 9, cost=cost)
    descend(search, rounds=4)
    assert len(search.dampings) == tries


@pytest.mark.parametrize(("left", "creeps"), [(4.0, False), (5.0, False), (6.0, True)])
def test_it_creeps_where_steps_without_damping_promise_ten_times_enough(
    left: float, creeps: bool
) -> None:
    assert descend(Told(ENDS, left=left))[2] is creeps


class Kink(OneByOne):
    """A residual that rises to both sides of 1, and another that is 0 there: forward differences
    promise more.
    """

    unknowns, simulated = (), 0
    blocks = (Block("kink", 1.0, 1), Block("straight", 1.0, 1))

    def __init__(self, steep: float) -> None:
        self.steep = steep

    def residuals(self, shared: np.ndarray, own: np.ndarray) -> list[np.ndarray]:
        off = shared[0] - 1.0
        return [np.array([0.5 + self.steep * abs(off)]), np.array([off])]


@pytest.mark.parametrize("lower", [-np.inf, 0.0], ids=["straight", "in two coordinates"])
@pytest.mark.parametrize(("steep", "converged"), [(0.1, True), (1.0, False)])
def test_where_no_step_helps_a_search_ends_if_little_was_promised(
    lower: float, steep: float, converged: bool
) -> None:
    """(steep / 2)² / (steep² + 1) of F: .0025 and .125, of which .01 is little."""
    solution = maximise([Unknown("x", 1.0, lower=lower)], [Kink(steep)])
    assert solution.values[0] == pytest.approx(1.0, abs=1e-9)
    assert solution.converged is converged
