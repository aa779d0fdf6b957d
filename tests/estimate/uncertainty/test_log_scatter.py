"""Readings that tell a direction and are left far more than the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from motorid.estimate.uncertainty import log_scatter

N, TELLING = 4000, 6


@dataclass(frozen=True)
class Line:
    """What of a record's linearised fit is asked for."""

    orthogonal: np.ndarray
    residual: np.ndarray


def line(excess: float, seed: int = 0) -> Line:
    """Two parameters: all readings tell the first, a few the second; those are left more."""
    rng = np.random.default_rng(seed)
    rows = np.column_stack([np.ones(N), np.zeros(N)])
    told = np.arange(TELLING) * (N // TELLING)
    rows[told, 1] = 40.0
    left = rng.standard_normal(N)
    left[told] = excess * np.where(np.arange(TELLING) % 2, 1.0, -1.0)
    return Line(rows, left)


def shifts(one: Line) -> list[np.ndarray]:
    white = one.orthogonal.T @ one.orthogonal
    return log_scatter._alone([one], np.linalg.inv(white), white, [])


def test_few_readings_that_are_left_more_widen_what_they_tell() -> None:
    rows = line(8.0).orthogonal
    usual = np.sqrt(np.linalg.inv(rows.T @ rows)[1, 1])
    total = np.sqrt(sum(shift[1] ** 2 for shift in shifts(line(8.0))))
    by_leverage = 1.0 / (1.0 - 1.0 / TELLING)  # of HC3: each has a sixth of the second
    assert total == pytest.approx(usual * np.sqrt((8.0 * by_leverage) ** 2 - 1.0), rel=0.05)


@pytest.mark.parametrize("seed", range(20))
def test_noise_widens_nothing(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    rows = np.column_stack([np.ones(N), rng.standard_normal(N)])
    assert not shifts(Line(rows, rng.standard_normal(N)))
