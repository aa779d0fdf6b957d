"""A step that meets bounds, against scipy's bounded least squares and by hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from motorid.estimate.solver.bounded_step import bounded_step
from motorid.estimate.solver.normal_equations import Normal
from motorid.estimate.solver.problem import Unknown
from motorid.estimate.solver.search_coordinates import Coordinates

Floats = NDArray[np.float64]
FREE = (-np.inf, np.inf)


@dataclass(frozen=True)
class Straight:
    """Readings r that fall by A s + C d, of shared unknowns (3,) and nuisances (2,)."""

    A: Floats
    C: Floats
    r: Floats

    @classmethod
    def drawn(cls, seed: int) -> Straight:
        rng = np.random.default_rng(seed)
        return cls(rng.normal(size=(20, 3)), rng.normal(size=(20, 2)), 3 * rng.normal(size=20))

    @property
    def normal(self) -> Normal:
        A, C, r = self.A, self.C, self.r
        return Normal(A.T @ A, A.T @ C, C.T @ C, A.T @ r, C.T @ r)


def coordinates(count: int, bounds: tuple[float, float]) -> Coordinates:
    return Coordinates([Unknown(f"x{k}", 0.1, *bounds) for k in range(count)])


def stepped(
    records: list[Straight],
    shared: tuple[float, float],
    own: tuple[float, float],
    damping: float = 0.0,
) -> Floats:
    """Of all unknowns, the nuisances of each record behind the shared ones."""
    frame, frames = coordinates(3, shared), [coordinates(2, own) for _ in records]
    starts, normals = [f.start for f in frames], [one.normal for one in records]
    ends, owned = bounded_step(frame, frame.start, frames, starts, normals, damping)
    return np.concatenate([ends, *owned]) - 0.1


def whole(records: list[Straight]) -> tuple[Floats, Floats]:
    """The same readings as one table, (n, 3 + 2 per record), and what they fall by."""
    rows = []
    for k, one in enumerate(records):
        row = np.zeros((len(one.r), 3 + 2 * len(records)))
        row[:, :3], row[:, 3 + 2 * k : 5 + 2 * k] = one.A, one.C
        rows.append(row)
    return np.concatenate(rows), np.concatenate([one.r for one in records])


def left(table: Floats, r: Floats, step: Floats) -> float:
    return float(np.sum((r - table @ step) ** 2))


@pytest.mark.parametrize("seed", range(4))
def test_without_bounds_it_is_least_squares(seed: int) -> None:
    records = [Straight.drawn(seed), Straight.drawn(seed + 10)]
    table, r = whole(records)
    assert stepped(records, FREE, FREE) == pytest.approx(np.linalg.lstsq(table, r, rcond=None)[0])


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("damping", [0.0, 1e-3, 1.0])
def test_within_bounds_the_readings_are_met_better_all_the_way(seed: int, damping: float) -> None:
    """Bounds of nuisances alone made a step of clipped ones worse than none."""
    records = [Straight.drawn(seed), Straight.drawn(seed + 50)]
    table, r = whole(records)
    for shared, own in ((FREE, (0.0, 0.3)), ((-0.1, 0.3), FREE), ((0.0, 0.2), (-0.2, 0.2))):
        step = stepped(records, shared, own, damping)
        low = np.repeat([shared[0], own[0]], [3, 4]) - 0.1
        high = np.repeat([shared[1], own[1]], [3, 4]) - 0.1
        assert (step >= low - 1e-12).all()
        assert (step <= high + 1e-12).all()
        best = lsq_linear(table, r, (low, high)).x
        assert left(table, r, step) >= left(table, r, best) * (1 - 1e-9)
        assert left(table, r, step) < left(table, r, np.zeros(7))


@pytest.mark.parametrize("seed", range(12))
def test_what_does_not_stop_is_where_the_others_leave_it(seed: int) -> None:
    """Least squares of the rest, with those that stopped where they did."""
    records = [Straight.drawn(seed)]
    step = stepped(records, FREE, (0.0, 0.2))
    table, r = whole(records)
    stopped = np.isclose(np.abs(step), 0.1) & (np.arange(5) > 2)
    rest = np.linalg.lstsq(
        table[:, ~stopped], r - table[:, stopped] @ step[stopped], rcond=None
    )[0]  # fmt: skip
    assert step[~stopped] == pytest.approx(rest)


@pytest.mark.parametrize(
    ("upper", "wanted"),
    [((9.0, 9.0), (2.0, -1.0)), ((1.0, 9.0), (1.0, -0.5)), ((1.0, -0.7), (1.0, -0.7))],
)
@pytest.mark.parametrize("nuisance", [False, True])
def test_what_stops_at_a_bound_changes_how_far_the_others_go(
    upper: tuple[float, float], wanted: tuple[float, float], nuisance: bool
) -> None:
    """2 a + b = 3 and a + 2 b = 0; with a = 1, b is -1/2."""
    a = Unknown("a", 0.0, upper=upper[0])
    b = Unknown("b", -1.0, lower=-4.0, upper=upper[1])
    x, H = np.array([0.0, -1.0]), np.array([[2.0, 1.0], [1.0, 2.0]])
    g = np.array([3.0, 0.0]) - H @ x
    owned = [b] if nuisance else []
    shared = Coordinates([a] if nuisance else [a, b])
    p = len(shared.unknowns)
    normal = Normal(H[:p, :p], H[:p, p:], H[p:, p:], g[:p], g[p:])
    end, (own,) = bounded_step(shared, x[:p], [Coordinates(owned)], [x[p:]], [normal], 0.0)
    assert [*end, *own] == pytest.approx(wanted)


def test_one_that_is_pulled_out_of_its_bounds_stays_and_one_that_is_pulled_in_goes() -> None:
    a = Coordinates([Unknown("a", 0.0)])
    c = Coordinates([Unknown("c", 0.0, lower=0.0), Unknown("d", 1.0, upper=1.0)])
    H = np.eye(2)
    normal = Normal(np.eye(1), np.zeros((1, 2)), H, np.ones(1), np.array([-1.0, -0.25]))
    end, (own,) = bounded_step(a, a.start, [c], [c.start], [normal], 0.0)
    assert [*end, *own] == pytest.approx([1.0, 0.0, 0.75])
