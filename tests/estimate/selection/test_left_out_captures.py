"""What captures say of one another, against least squares by numpy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.selection.left_out_captures import foretold, given_up
from motorid.estimate.solver.problem import Linearised, Solution, Unknown

Floats = NDArray[np.float64]
DRAWN = np.random.default_rng(11)
TABLES = [DRAWN.standard_normal((20 + 10 * k, 3)) * [1.0, 30.0, 0.01] for k in range(3)]
READINGS = [table @ [0.4, -0.02, 30.0] + DRAWN.standard_normal(len(table)) for table in TABLES]


def line(table: Floats, residual: Floats) -> Linearised:
    """A record without nuisances whose readings are as sure as 1."""
    none = np.zeros((len(residual), 0))
    parts = (slice(0, len(residual)),)
    return Linearised(residual, table, none, table, np.zeros(0), (), parts, np.ones(1))


def solved(
    tables: list[Floats], readings: list[Floats], at: Floats, sd: float = np.inf
) -> Solution:
    """A solution at a point; ``sd``: of the first unknown, a prior about 0.5."""
    p = tables[0].shape[1]
    unknowns = tuple(
        Unknown(f"x{k}", 0.0, prior_mean=0.5, prior_sd=sd if k == 0 else np.inf) for k in range(p)
    )
    lines = tuple(line(t, y - t @ at) for t, y in zip(tables, readings, strict=True))
    prior = np.diag([sd**-2.0, *np.zeros(p - 1)])
    information = prior + np.sum([t.T @ t for t in tables], axis=0)
    held = np.zeros(p, dtype=bool)
    return Solution(unknowns, at, (), (), information, held, lambda: lines, 0.0, 0, True)


def likeliest(tables: list[Floats], readings: list[Floats], sd: float = np.inf) -> Floats:
    p = tables[0].shape[1]
    rows = np.vstack([*tables, np.eye(1, p) / sd])
    return np.asarray(np.linalg.lstsq(rows, np.concatenate([*readings, [0.5 / sd]]), rcond=None)[0])


def misfit(tables: list[Floats], readings: list[Floats], at: Floats, sd: float) -> float:
    rows = zip(tables, readings, strict=True)
    return float(sum(np.sum((y - t @ at) ** 2) for t, y in rows) + ((at[0] - 0.5) / sd) ** 2)


def without(k: int) -> tuple[list[Floats], list[Floats]]:
    return [t for j, t in enumerate(TABLES) if j != k], [
        y for j, y in enumerate(READINGS) if j != k
    ]


@pytest.mark.parametrize("sd", [np.inf, 0.05])
@pytest.mark.parametrize("short", [0.0, 0.3])
def test_what_is_given_up_is_what_the_others_would_gain(sd: float, short: float) -> None:
    """From the top of all, wherever a search has stopped ``short`` of it."""
    top = likeliest(TABLES, READINGS, sd)
    expected = sum(
        misfit(*without(k), top, sd) - misfit(*without(k), likeliest(*without(k), sd), sd)
        for k in range(3)
    )
    found = given_up(solved(TABLES, READINGS, top + short * np.array([0.1, 0.01, 3.0]), sd))
    assert found == pytest.approx(expected, rel=1e-6)


def test_one_that_is_held_gives_nothing_up() -> None:
    top = likeliest([t[:, :2] for t in TABLES], READINGS)
    held = solved(TABLES, READINGS, np.array([*top, 0.0]))
    held = replace(held, at_bound=np.array([False, False, True]))
    free = solved([t[:, :2] for t in TABLES], READINGS, top)
    assert given_up(held) == pytest.approx(given_up(free), rel=1e-6)


@pytest.mark.parametrize(
    ("sizes", "expected"), [((10.0, 1.0), 20.0), ((10.0, -2.0), -40.0), ((3.0, 3.0), 18.0)]
)
def test_captures_that_see_opposite_sizes_disagree(
    sizes: tuple[float, float], expected: float
) -> None:
    """Two captures, each sure by 1 of a size: together they gain half the square of the sum; each
    alone the square of its own.
    """
    tables = [np.ones((1, 1)), np.ones((1, 1))]
    readings = [np.array([size]) for size in sizes]
    wider = solved(tables, readings, np.array([sum(sizes) / 2.0]))
    narrower = replace(solved(tables, readings, np.zeros(1)), at_bound=np.ones(1, dtype=bool))
    gain = sum(sizes) ** 2 / 2.0
    assert foretold(gain, wider, narrower) == pytest.approx(expected)
