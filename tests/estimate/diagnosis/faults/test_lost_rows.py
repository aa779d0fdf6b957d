"""Rows that a log lacks under renewed stamps are named; no jump that a motor makes is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.diagnosis.faults.lost_rows import _Lines, suspects
from tests.estimate.diagnosis.facts.made_log import LEVEL_S, PERIOD_S, log, rounded, rows, truth

LEVEL = round(LEVEL_S / PERIOD_S)  # rows


def test_rows_that_are_missing_are_named() -> None:
    capture = log(0.3)
    kept = np.flatnonzero(np.random.default_rng(2).random(len(capture)) > 0.02)
    (said,) = suspects(rows(capture, kept))
    assert said.code == "samples_dropped"
    assert "whole rows" in said.evidence
    assert said.moves["J"] == np.inf


def test_a_stretch_that_was_cut_out_is_named() -> None:
    capture = log()
    begin = 2 * LEVEL + 20
    kept = np.r_[:begin, begin + 120 : len(capture)]
    (said,) = suspects(rows(capture, kept))
    assert "a stretch is missing" in said.evidence
    assert f"{begin * PERIOD_S:.4g} s" in said.evidence


@pytest.mark.parametrize("noise", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("bits", [0, 8, 12])
def test_a_whole_log_is_not_accused(noise: float, bits: int) -> None:
    assert suspects(rounded(log(noise), bits)) == []


@pytest.mark.parametrize("late", [1, 5, 12])
def test_a_late_current_is_not_accused(late: int) -> None:
    shown = np.r_[np.zeros(late), truth()[CURRENT][:-late]]
    assert suspects(log(0.3, **{CURRENT: shown})) == []


def test_a_sensor_that_fails_for_a_while_is_no_missing_row() -> None:
    speed = truth()[SPEED].copy()
    speed[3 * LEVEL - 40 : 3 * LEVEL - 20] = 0.0
    assert suspects(log(**{SPEED: speed})) == []


def test_a_pause_that_the_stamps_show_is_not_accused() -> None:
    capture = log()
    kept = np.r_[: 2 * LEVEL + 20, 2 * LEVEL + 140 : len(capture)]
    stamped = replace(rows(capture, kept), ticks=capture.ticks[kept])
    assert suspects(stamped) == []


@pytest.mark.parametrize("count", [1.0, 3.07])
def test_a_coarse_channel_that_mostly_stays_is_not_taken_for_exact(count: float) -> None:
    """Edges a row: its usual third difference is nothing, and a line through it is known to about a
    third of a count, not to a millionth of its range.
    """
    rng = np.random.default_rng(3)
    speed = count * (30.0 + (rng.random(600) < 0.1))
    lines = _Lines.of(speed, 10)
    assert count / 5 < np.sqrt(lines.variance) < count
    assert np.abs(lines.jump).max() < 5 * np.sqrt(lines.variance)


def test_a_smooth_channel_stays_exact() -> None:
    speed = 400.0 * (1.0 - np.exp(-np.arange(600) / 80.0))
    assert np.sqrt(_Lines.of(speed, 10).variance) < 0.01
