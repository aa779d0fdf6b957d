"""Readings that tell a direction and are left far more than the others."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.uncertainty import uneven_residuals

N, TELLING = 4000, 6


@dataclass(frozen=True)
class Line:
    """What of a record's linearised fit is asked for; ``sigma`` of a block with a noise of one."""

    orthogonal: np.ndarray
    residual: np.ndarray
    sigmas: tuple[float, ...] = (1.0,)
    blocks: tuple[Any, ...] = (SimpleNamespace(floor=1.0),)


def line(excess: float, seed: int = 0, sigma: float = 1.0) -> Line:
    """Two parameters: all readings tell the first, a few the second; those are left more."""
    rng = np.random.default_rng(seed)
    rows = np.column_stack([np.ones(N), np.zeros(N)])
    told = np.arange(TELLING) * (N // TELLING)
    rows[told, 1] = 40.0
    left = rng.standard_normal(N)
    left[told] = excess * np.where(np.arange(TELLING) % 2, 1.0, -1.0)
    return Line(rows, left, (sigma,))


def shifts(one: Line) -> list[np.ndarray]:
    white = one.orthogonal.T @ one.orthogonal
    return uneven_residuals.shifts([one], np.linalg.inv(white), [])  # type: ignore[list-item]


def test_few_readings_that_are_left_more_widen_what_they_tell() -> None:
    rows = line(8.0).orthogonal
    usual = np.sqrt(np.linalg.inv(rows.T @ rows)[1, 1])
    total = np.sqrt(sum(shift[1] ** 2 for shift in shifts(line(8.0))))
    by_leverage = 1.0 / (1.0 - 1.0 / TELLING)  # of HC3: each has a sixth of the second
    assert total == pytest.approx(usual * np.sqrt((8.0 * by_leverage) ** 2 - 1.0), rel=0.05)


def test_what_is_known_is_not_counted_twice() -> None:
    one = line(8.0)
    known = shifts(one)
    inverse = np.linalg.inv(one.orthogonal.T @ one.orthogonal)
    assert uneven_residuals.shifts([one], inverse, known) == []  # type: ignore[list-item]


@pytest.mark.parametrize("seed", range(20))
def test_noise_widens_nothing(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    rows = np.column_stack([np.ones(N), rng.standard_normal(N)])
    assert not shifts(Line(rows, rng.standard_normal(N)))


@pytest.mark.parametrize(
    ("sigma", "waveform", "widened"),
    [(1.0, None, True), (1.49, None, True), (1.51, None, False), (1.0, "of a log", False)],
)
def test_captures_without_a_lack_of_fit_count_what_few_readings_are_left(
    sigma: float, waveform: str | None, widened: bool
) -> None:
    one = line(8.0, sigma=sigma)
    information = one.orthogonal.T @ one.orthogonal
    solution: Any = SimpleNamespace(records=(one,), information=information)
    record: Any = SimpleNamespace(sensed=SimpleNamespace(waveform=waveform))
    assert bool(uneven_residuals.of_captures(solution, [record])) is widened
