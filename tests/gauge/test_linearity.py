"""When a gauge's bias line is acceptable."""

from __future__ import annotations

import pytest

from motorid.quality.reference import Line, LinearityResult

FLAT = Line(0.0, 1.0, 0.0, 1.0)


def result(*band: tuple[float, float, float]) -> LinearityResult:
    """Of motors at 1 and 2; the band may be drawn at more."""
    return LinearityResult(10, FLAT, FLAT, 0.0, 1.0, 8, ((1.0, 0.0), (2.0, 0.0)), band)


@pytest.mark.parametrize(("low", "high"), [(-1.0, 1.0), (0.0, 1.0), (-1.0, 0.0)])
def test_zero_on_the_edge_of_the_band_is_within_it(low: float, high: float) -> None:
    assert result((1.0, low, high), (2.0, -1.0, 1.0)).acceptable


@pytest.mark.parametrize(("low", "high"), [(0.1, 1.0), (-1.0, -0.1)])
def test_one_motor_beyond_is_enough_and_only_motors_count(low: float, high: float) -> None:
    assert not result((1.0, -1.0, 1.0), (2.0, low, high)).acceptable
    assert result((1.0, -1.0, 1.0), (2.0, -1.0, 1.0), (3.0, low, high)).acceptable
