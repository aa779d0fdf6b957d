"""Within which sizes a fault is looked for: they follow the capture's own period and speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, Capture
from motorid.estimate.diagnosis.faults import encoder_bandwidth, saturation
from motorid.estimate.diagnosis.faults.filters import low_pass_filter
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.exact_capture import FAULHABER, Plan, clean_capture


def record(capture: Capture) -> MotorRecord:
    return MotorRecord(capture, PARAMETERS, {})


@pytest.mark.parametrize("period_s", [1e-4, 2e-4])
def test_a_low_pass_is_looked_for_from_a_thousandth_of_a_sample_to_hundreds(
    period_s: float,
) -> None:
    subject = record(clean_capture(FAULHABER, Plan(count=400, period_s=period_s)))
    own = subject.timeline.period_s
    found, *smoothed = low_pass_filter.hypotheses([subject])
    assert {one.code for one in smoothed} == {"current_smoothed", "voltage_filtered"}
    assert found.lower == pytest.approx((1e-3 * own,))
    assert found.upper == pytest.approx((500.0 * own,))
    assert all(found.lower < size < found.upper for size in found.sizes)


def losing(capture: Capture, fastest: float) -> Capture:
    """Its counter follows no more than so many rad/s."""
    channel = capture.channels[POSITION]
    most = fastest * capture.period_s
    moved = np.clip(np.diff(channel.raw, prepend=channel.raw[0]), -most, most)
    channels = {**capture.channels, POSITION: replace(channel, raw=np.cumsum(moved))}
    return replace(capture, channels=channels)


@pytest.mark.slow
def test_an_encoder_is_suspected_where_the_motor_outruns_it() -> None:
    whole = clean_capture(FAULHABER, Plan(volts=(6.0, 3.0, 4.5), count=4000))
    peak = float(np.abs(np.diff(whole.channels[POSITION].raw)).max() / whole.period_s)
    assert encoder_bandwidth.seen([record(whole)]) is None
    seen = encoder_bandwidth.seen([record(losing(whole, 0.9 * peak))])
    assert seen is not None
    hypothesis, begin = seen
    (size,) = hypothesis.sizes[0]
    assert size == pytest.approx(0.9 * peak, rel=0.01)  # the fastest that it shows
    assert begin.size[0] == pytest.approx(0.97 * size)
    assert hypothesis.lower[0] == pytest.approx(0.5 * size)
    assert hypothesis.upper[0] == pytest.approx(1.5 * size)
    slight = losing(whole, 0.99 * peak)  # less than what is clear
    assert encoder_bandwidth.seen([record(slight)]) is None


def test_a_current_that_stops_is_looked_for_below_its_highest_reading() -> None:
    subject = record(clean_capture(FAULHABER, Plan(count=400)))
    (found,) = saturation.hypotheses([subject])
    current = subject.block(CURRENT)
    assert current is not None
    peak = float(np.abs(current.values).max())
    assert [size for (size,) in found.sizes] == pytest.approx(
        [share * peak for share in (0.97, 0.9, 0.8, 0.65)]
    )
    assert found.scale == pytest.approx((0.01 * peak,))
    assert (found.lower, found.upper) == (
        pytest.approx((0.05 * peak,)), pytest.approx((1.2 * peak,)),
    )  # fmt: skip
    said = found.words(np.array([1.234]))
    assert (said.where, "stop at 1.23 A" in said.evidence) == ("current", True)
    assert saturation.hypotheses([]) == []


def test_a_voltage_that_stops_gives_more_than_it_shows() -> None:
    found = saturation._voltage(8.0)
    assert (found.code, found.sizes) == ("voltage_saturated", ((1.02,),))
    assert (found.scale, found.lower, found.upper) == ((0.05,), (1.0,), (3.0,))
    said = found.words(np.array([1.25]))
    assert said.where == "terminal voltage"
    assert "stop at 8 V, where the motor answers as to 10 V" in said.evidence


def test_a_current_is_declared_to_end_a_little_below_where_it_stops() -> None:
    """In raw units, and never beyond the end that is declared already."""
    capture = clean_capture(FAULHABER, Plan(count=400))
    channel = replace(capture.channels[CURRENT], scale=-0.5, offset=10.0, raw_max=13.0)
    given = replace(capture, channels={**capture.channels, CURRENT: channel})
    (ended,) = saturation._declared_end(CURRENT, given, 2.0)
    current = ended.channels[CURRENT]
    assert (current.raw_min, current.raw_max) == pytest.approx((10.0 - 3.88, 13.0))
    (wide,) = saturation._declared_end(CURRENT, capture, 2.0)
    assert wide.channels[CURRENT].raw_max == pytest.approx(0.97 * 2.0)
