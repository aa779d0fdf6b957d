"""Straight pieces: lines through a few points against numpy's own, and where they part."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.segment.pieces import Pieces, _cheapest, straight_pieces

TIMES = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0, 7.0, 9.0])
ROUGH = np.array([0.3, -0.2, 0.1, 0.4, -0.3, 0.2, -0.1, -0.2])
PLAIN = np.ones(7, dtype=bool)


def pieces(signals: NDArray[np.float64], sigma: list[float], **how: object) -> Pieces:
    joined, penalty = how.get("joined", PLAIN), how.get("penalty", 30.0)
    return straight_pieces(TIMES, signals, np.array(sigma), joined, penalty)  # type: ignore[arg-type]


def test_one_piece_is_the_line_of_least_squares_of_each_signal() -> None:
    signals = np.column_stack([2.0 + 3.0 * TIMES + ROUGH, 5.0 - TIMES - 2.0 * ROUGH])
    found = pieces(signals, [0.5, 0.7])
    assert (found.first.tolist(), found.stop.tolist()) == ([0], [8])
    assert found.middle == pytest.approx([TIMES.mean()])
    assert found.level[0] == pytest.approx(signals.mean(axis=0))
    lines = [np.polyfit(TIMES, signal, 1) for signal in signals.T]
    assert found.slope[0] == pytest.approx([line[0] for line in lines])
    spread = np.sqrt(np.sum((TIMES - TIMES.mean()) ** 2))
    assert found.slope_error[0] == pytest.approx([0.5 / spread, 0.7 / spread])
    whole = np.zeros(8, dtype=np.int64)
    for signal, line in enumerate(lines):
        assert found.at(whole, TIMES, signal) == pytest.approx(np.polyval(line, TIMES))
    assert found.at(whole, TIMES) == pytest.approx(np.polyval(lines[0], TIMES))


def test_a_break_parts_a_line_and_a_piece_of_one_block_has_no_slope() -> None:
    signals = (2.0 + 3.0 * TIMES)[:, None]
    found = pieces(signals, [0.5], joined=np.array([True, True, False, True, True, True, False]))
    assert (found.first.tolist(), found.stop.tolist()) == ([0, 3, 7], [3, 7, 8])
    assert found.slope[:, 0] == pytest.approx([3.0, 3.0, 0.0])
    assert found.slope_error[2, 0] == np.inf
    assert found.middle == pytest.approx([1.0, 5.5, 9.0])
    assert found.level[:, 0] == pytest.approx([5.0, 18.5, 29.0])


@pytest.mark.parametrize(("factor", "parts"), [(0.99, 2), (1.01, 1)])
def test_two_lines_become_one_where_that_costs_no_more_than_the_penalty(
    factor: float, parts: int
) -> None:
    step = np.r_[np.zeros(4), np.ones(4)]
    sigma = np.array([0.1, 0.2])
    signals = np.column_stack([step, -2.0 * step])
    one = np.polynomial.polynomial.polyfit(TIMES, signals, 1)
    left = signals - (one[0] + np.outer(TIMES, one[1]))
    cost = float(np.sum((left / sigma) ** 2))  # of a joint line; two have none
    found = pieces(signals, list(sigma), penalty=factor * cost)
    assert len(found.first) == parts


def test_neighbours_join_the_cheapest_first() -> None:
    cost = np.array([3.0, 1.0, 2.0, 0.5, np.inf, 4.0])
    assert np.flatnonzero(_cheapest(cost, 1e-9)).tolist() == [1, 3, 5]
    assert np.flatnonzero(_cheapest(np.array([1.0]), 1e-9)).tolist() == [0]
    assert _cheapest(np.array([np.inf, np.inf]), 1e-9).sum() <= 1


def test_equal_costs_are_told_apart_so_that_no_two_pairs_share_a_piece() -> None:
    chosen = np.flatnonzero(_cheapest(np.zeros(50), 1e-6))
    assert len(chosen) > 10
    assert np.diff(chosen).min() > 1


def test_a_single_block_is_a_piece() -> None:
    found = straight_pieces(
        np.array([3.0]), np.array([[7.0]]), np.array([0.5]), np.zeros(0, dtype=bool), 30.0
    )
    assert (found.first.tolist(), found.stop.tolist()) == ([0], [1])
    assert (found.middle[0], found.level[0, 0]) == (3.0, 7.0)
