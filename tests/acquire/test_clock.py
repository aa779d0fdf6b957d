"""The clock of a capture: calibrated, or as the board states its largest error."""

from __future__ import annotations

import math

import pytest

from motorid.acquire.clock_check import of_identity

BOARD = {"clock_hz": 16_000_000, "clock_uncertainty_ppm": 60}


def test_the_boards_largest_error_is_evenly_spread() -> None:
    rate, uncertainty, _ = of_identity(BOARD)
    assert rate == 16e6
    assert uncertainty == pytest.approx(60e-6 / math.sqrt(3.0), rel=1e-12)


def test_a_calibration_takes_its_place() -> None:
    rate, uncertainty, _ = of_identity(BOARD, rate=1.00002, uncertainty=2e-6)
    assert rate == pytest.approx(16_000_320.0, rel=1e-12)
    assert uncertainty == 2e-6


def test_a_perfect_calibration_counts() -> None:
    assert of_identity(BOARD, uncertainty=0.0)[1] == 0.0
