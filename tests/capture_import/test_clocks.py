"""Which clock a time column gives: its stamps as they stand, their grid, and rows that are left."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.stamps import Clock, clock_of
from motorid.errors import DataError

SOURCE: Any = SimpleNamespace(place=lambda row: f"line {row + 2}")


def clock(
    stamps: Any, *, unit_s: float = 1e-3, drop_bad: bool = False, first_row: int = 0, **values: Any
) -> tuple[Clock, list[str]]:
    """The clock of stamps in ms, and what is said; rows count from ``first_row``."""
    notes: list[str] = []
    array = np.array(stamps, dtype=float)
    columns = {"row": first_row + np.arange(float(len(array))), **values}
    return clock_of(Path("a.csv"), SOURCE, array, unit_s, columns, drop_bad, notes), notes


def test_regular_stamps_are_kept_in_nanoseconds() -> None:
    found, notes = clock([5.0, 7.0, 9.0, 13.0])
    assert found.ticks.tolist() == [0, 2_000_000, 4_000_000, 8_000_000]
    assert (found.hz, found.uncertainty, found.ahead, found.grid) == (1e9, 0.0, None, None)
    assert notes == []


def test_a_single_stamp_is_a_clock() -> None:
    assert clock([5.0])[0].ticks.tolist() == [0]


def test_stamps_that_no_grid_explains_are_kept() -> None:
    stamps = np.cumsum(1.0 + np.arange(40) % 7 * 0.31)
    found, notes = clock(stamps)
    assert found.ticks == pytest.approx(1e6 * (stamps - stamps[0]), abs=1.0)
    assert (found.hz, found.uncertainty, found.ahead, found.grid) == (1e9, 0.0, None, None)
    assert notes == []


ROWS = np.arange(90)
SEVERAL = np.floor((ROWS + 0.3) / 2.7)  # two or three samples of one stamp


def test_samples_that_share_a_stamp_lie_on_the_grid_of_all() -> None:
    found, notes = clock(SEVERAL, w=np.sin(1.0 * ROWS))
    assert found.grid is not None
    assert found.ahead is None
    step = found.ticks[1]
    assert np.array_equal(found.ticks, ROWS * step)
    assert step == pytest.approx(1e6 / 2.7, rel=0.02)
    assert found.hz == pytest.approx(1e9, rel=1e-5)
    assert 0.0 < found.uncertainty < 0.02
    assert len(notes) == 1
    assert "stamps are rounded to 0.001 s" in notes[0]


def test_rows_that_copy_the_row_before_them_are_left_out() -> None:
    readings = np.repeat(np.sin(np.arange(45.0)), 2)
    stamps = np.repeat(np.arange(45.0), 2)
    found, notes = clock(stamps, w=readings, first_row=9)
    assert found.ahead is not None
    assert np.array_equal(np.flatnonzero(found.ahead), np.arange(0, 90, 2))
    assert np.array_equal(found.ticks, 1_000_000 * np.arange(45))
    assert notes == ["45 rows that copy the row before them left out"]


def test_rows_that_repeat_a_stamp_with_another_reading_are_left_out_if_told() -> None:
    readings = np.repeat(np.sin(np.arange(45.0)), 2)
    readings[7] += 0.1
    stamps = np.repeat(np.arange(45.0), 2)
    with pytest.raises(DataError, match=r"line 12 repeats the stamp"):
        clock(stamps, w=readings, first_row=9)
    found, notes = clock(stamps, w=readings, drop_bad=True, first_row=9)
    assert found.ahead is not None
    assert np.array_equal(np.flatnonzero(found.ahead), np.arange(0, 90, 2))
    assert np.array_equal(found.ticks, 1_000_000 * np.arange(45))
    assert notes == ["45 rows left out whose stamps do not advance; the first: line 12"]


def test_what_is_left_of_rounded_stamps_lies_on_a_grid() -> None:
    """Cut to whole ms from a period of 12.5 ms; one row steps back."""
    moments = np.floor(12.5 * np.arange(60.0))
    found, _ = clock(np.insert(moments, 30, 5.0), drop_bad=True)
    assert found.ahead is not None
    assert np.flatnonzero(~found.ahead).tolist() == [30]
    assert found.grid is not None
    assert np.array_equal(found.ticks, np.arange(60) * found.ticks[1])
    assert found.ticks[1] / found.hz == pytest.approx(12.5e-3, rel=2e-3)


def test_where_stamps_step_back_no_grid_is_looked_for() -> None:
    stamps = SEVERAL.copy()
    stamps[40] -= 3.0
    with pytest.raises(DataError, match=r"repeats the stamp .*--drop-bad"):
        clock(stamps, w=np.sin(1.0 * ROWS))
