"""Two lines of an encoder become counts; lost edges are said, and never guessed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.capture.quadrature import counts, is_pair
from motorid.capture.table import read_table
from motorid.errors import DataError, UsageError

STATES = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)


def lines(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lines A and B of an encoder at such counts."""
    state = STATES[places % 4]
    return state[:, 0], state[:, 1]


@pytest.mark.slow
@given(st.lists(st.sampled_from([-1, 0, 1]), min_size=4, max_size=200))
def test_counts_follow_any_path(steps: list[int]) -> None:
    places = np.concatenate([[0, 1, 2], 2 + np.cumsum(steps)])  # each line has had both levels
    np.testing.assert_array_equal(counts(*lines(places)), places)


def test_an_analogue_line_is_high_above_its_middle() -> None:
    a, b = lines(np.arange(12))
    rng = np.random.default_rng(2)
    noisy = [3.3 * line + 0.3 * rng.standard_normal(12) for line in (a, b)]
    np.testing.assert_array_equal(counts(*noisy), np.arange(12))


def test_lost_edges_stop_the_import(tmp_path: Path) -> None:
    a, b = lines(np.array([0, 1, 2, 4, 5, 6]))
    assert not is_pair(a, b, 1)
    rows = (f"{k / 1000},{x:.0f},{y:.0f}" for k, (x, y) in enumerate(zip(a, b, strict=True)))
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,A,B", *rows]) + "\n", encoding="ascii")
    maps = ["time=t:s", "position=quadrature(A,B):counts"]
    with pytest.raises(DataError, match=r"row 4 \(1 times"):
        read_table(path, maps, counts_per_turn=400)
    for wrong in ("quadrature(A)", "quadrature(A,B,A)", "quadrature(A,2)", "sqrt(A,B)"):
        with pytest.raises(UsageError, match="no column"):
            read_table(path, ["time=t:s", f"position={wrong}:counts"], counts_per_turn=400)


def test_a_missing_reading_keeps_the_count() -> None:
    a, b = lines(np.array([0, 1, 2, 2, 3, 4]))
    a[3] = np.nan
    np.testing.assert_array_equal(counts(a, b), [0, 1, 2, np.nan, 3, 4])
