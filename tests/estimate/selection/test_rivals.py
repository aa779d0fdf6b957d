"""Rivals by their price, and a size at the shape that was found."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.selection.evidence import Price, deviation_at, in_order


def test_the_best_price_comes_first() -> None:
    prices = [Price(-90.0, 1, 10.0), Price(-140.0, 2, 10.0), Price(-110.0, 1, 10.0)]
    assert in_order(prices) == [1, 2, 0]
    assert in_order([]) == []


def test_of_prices_that_differ_by_too_little_the_simpler_comes_first() -> None:
    prices = [Price(-140.0, 2, 20.0), Price(-125.0, 1, 20.0), Price(-100.0, 1, 20.0)]
    assert in_order(prices) == [1, 0, 2]


def test_a_size_is_sharper_where_its_shape_is_known() -> None:
    """Of two with correlation r, the one has sqrt(1 - r²) of its deviation at the other."""
    table = np.array([[4e-12, 1.8e-6, 0.0], [1.8e-6, 1.0, 0.0], [0.0, 0.0, 9.0]])
    assert deviation_at(table, 0, []) == pytest.approx(2e-6)
    assert deviation_at(table, 0, [2]) == pytest.approx(2e-6)
    assert deviation_at(table, 0, [1, 2]) == pytest.approx(2e-6 * np.sqrt(1 - 0.9**2))
    table[1, 1] = np.inf  # which nothing bounds
    assert deviation_at(table, 0, [1]) == np.inf
    assert deviation_at(table, 0, [2]) == pytest.approx(2e-6)
