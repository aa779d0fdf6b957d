"""Readings that tell a direction and are left far more than the others."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

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


@pytest.mark.parametrize(("behind", "share"), [(0.0, 0.5), (2.0, 0.26894), (40.0, 0.0)])
def test_a_rival_widens_by_its_distance_and_how_likely_it_is(behind: float, share: float) -> None:
    """Of two answers with odds of exp(-F/2): the variance about the first is share times d²."""
    solution: Any = SimpleNamespace(
        unknowns=[SimpleNamespace(log=True), SimpleNamespace(log=False)],
        values=np.array([2.0, 5.0]),
    )  # fmt: skip
    rival = SimpleNamespace(behind=behind, values=np.array([3.0, 4.0]))
    record: Any = SimpleNamespace(rivals=[rival])
    (shift,) = log_scatter._rivals(solution, record)
    distance = np.array([np.log(1.5), -1.0])  # of a logarithm, and of a value
    assert shift == pytest.approx(distance * np.sqrt(share), abs=1e-4)
    record.rivals = []
    assert log_scatter._rivals(solution, record) == []
