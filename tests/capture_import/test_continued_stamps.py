"""Stamps of a counter that wraps, or of a logger that begins anew, go on."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.continued_stamps import continued, stale, without_stale

ROWS = np.arange(300.0)


@pytest.mark.parametrize(
    ("period", "size", "unit_s"),
    [
        (500.0, 2.0**32, 1e-6),
        (0.5, 2.0**32 * 1e-3, 1e-3),  # of µs, written in ms
        (1.0, 2.0**16, 1e-3),
        (0.01, 86400.0, 1.0),
        (1.0, 86400e3, 1e-3),
    ],
)
def test_a_counter_or_a_time_of_day_that_wraps_is_continued(
    period: float, size: float, unit_s: float
) -> None:
    true = size - 120.4 * period + period * ROWS
    notes: list[str] = []
    assert continued(true % size, unit_s, notes) == pytest.approx(true, rel=1e-12)
    assert len(notes) == 1
    assert "wraps" in notes[0]


def test_a_signed_counter_wraps_too() -> None:
    true = 2.0**31 - 100.0 + ROWS
    shown = (true + 2.0**31) % 2.0**32 - 2.0**31
    assert continued(shown, 1e-6, []) == pytest.approx(true, rel=1e-12)


def test_a_logger_that_begins_anew_gives_another_run_behind_a_pause() -> None:
    notes: list[str] = []
    found = continued(np.r_[ROWS, 0.2 + ROWS, ROWS], 1e-3, notes)
    steps = np.diff(found)
    assert np.flatnonzero(steps > 2.0).tolist() == [299, 599]
    assert steps.min() == pytest.approx(1.0)
    assert "begins anew at 2 places" in notes[0]


@pytest.mark.parametrize(
    "shown",
    [
        ROWS,
        np.where(ROWS == 150.0, 3.0, ROWS),  # one row that steps back
        np.r_[ROWS, 5.0, ROWS],  # a run of one row
        np.r_[ROWS, 140.0 + ROWS],  # rows that were written again
        np.sort(ROWS)[::-1],
    ],
)
def test_other_stamps_stay_as_they_are(shown: np.ndarray) -> None:
    notes: list[str] = []
    assert np.array_equal(continued(shown, 1e-3, notes), shown)
    assert notes == []


@pytest.mark.parametrize(("early", "count"), [([7.4], 1), ([7.4, 7.41], 2), ([], 0)])
def test_stamps_from_before_the_clock_was_set_are_stale(early: list[float], count: int) -> None:
    stamps = np.concatenate([early, 0.02 + 0.02 * ROWS])
    notes: list[str] = []
    assert stale(stamps) == without_stale(stamps, 1.0, notes) == count
    assert bool(notes) == bool(count)


@pytest.mark.parametrize(
    "stamps",
    [
        np.concatenate([[7.4, 7.41, 7.42, 7.43], 0.02 * ROWS]),  # a run of its own
        np.concatenate([[7.4], 0.02 * ROWS[:10]]),  # too few rows to say
        np.concatenate([[7.4], 0.02 * ROWS[:50], 0.02 * ROWS]),  # more than the start is wrong
        np.concatenate([[0.0], 0.02 * ROWS]),  # a copy
    ],
)
def test_other_stamps_that_do_not_advance_are_not_stale(stamps: np.ndarray) -> None:
    assert stale(stamps) == 0


def test_a_counter_that_wraps_in_its_first_rows_is_not_stale() -> None:
    stamps = np.concatenate([[65534.0, 65535.0], ROWS])
    assert stale(stamps) == 2
    assert without_stale(stamps, 1e-3, []) == 0
