"""Positions of registers that overflow, and of sensors that begin anew each turn."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.wrapped_position import continued

TRUE = np.cumsum(np.concatenate([np.full(300, 2.5), np.full(500, -1.5), np.full(200, 0.1)]))


@pytest.mark.parametrize("size", [256.0, 360.0, 65536.0, 2 * np.pi, 1.0, 4000.0])
@pytest.mark.parametrize("begins", [0.0, -0.5])
def test_a_position_goes_on_where_its_register_begins_anew(size: float, begins: float) -> None:
    turns = TRUE * size / 100.0
    wrapped = (turns - begins * size) % size + begins * size
    notes: list[str] = []
    found = continued(wrapped, 4000.0, notes)
    assert found - found[0] == pytest.approx(turns - turns[0], abs=1e-9 * size)
    (said,) = notes
    assert f"jumps by {size:.6g} at" in said


def test_a_reading_that_is_missing_stays_so() -> None:
    wrapped = (TRUE * 5.0) % 256.0
    wrapped[[10, 200]] = np.nan
    found = continued(wrapped, 0.0, [])
    assert np.flatnonzero(np.isnan(found)).tolist() == [10, 200]
    known = np.isfinite(found)
    assert (found - found[0])[known] == pytest.approx((TRUE - TRUE[0])[known] * 5.0)


@pytest.mark.parametrize(
    "values",
    [
        TRUE,  # goes to and fro
        np.where(np.arange(1000) < 400, TRUE, TRUE - 300.0),  # set to zero by hand: of no size
        np.arange(1000) // 3 % 2,  # a count that flickers
        np.full(1000, 7.0),
        np.array([1.0]),
        np.random.default_rng(3).uniform(0.0, 256.0, 1000),  # changes as it likes
    ],
)  # fmt: skip
def test_others_stay_as_they_are(values: np.ndarray) -> None:
    notes: list[str] = []
    assert continued(np.asarray(values, dtype=float), 4000.0, notes).tolist() == values.tolist()
    assert not notes
