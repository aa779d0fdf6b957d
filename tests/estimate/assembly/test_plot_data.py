"""What a report plots: times, readings and segments, as the capture has them."""

from __future__ import annotations

import pytest

from motorid.estimate.assembly import plot_data
from motorid.segment.types import Segment, SegmentKind
from tests.estimate.uncertainty.test_budget import fitted


def test_a_curve_is_the_readings_beside_the_model() -> None:
    records, solution = fitted("measured")
    curves = plot_data.curves(solution, records)
    assert len(curves) == len(records[0].measured)
    for curve, m in zip(curves, records[0].measured, strict=True):
        values = vars(curve).values()
        assert any(value is m.values for value in values)
        assert m.block.name in values


def test_segments_say_when_they_are_and_empty_ones_are_left_out() -> None:
    records, _ = fitted("measured")
    capture = records[0].capture
    stretches = [
        Segment(SegmentKind.REST, 0, 20), Segment(SegmentKind.STEADY, 20, 20),
        Segment(SegmentKind.COAST, 300, 400, "open"),
    ]  # fmt: skip
    first, last = plot_data.segments([(capture, stretches)])
    assert list(vars(first).values())[:2] == [0, "rest"]
    assert list(vars(last).values())[2:] == [
        pytest.approx(0.03), pytest.approx(0.0399), "open",
    ]  # fmt: skip
