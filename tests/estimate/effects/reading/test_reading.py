"""What channels show of a current or a motion: gains, zeros, filters, and which way each moves."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.effects import scales
from motorid.estimate.effects.action import plus, times
from motorid.estimate.effects.influence_quantity import InfluenceQuantity
from motorid.estimate.effects.reading.current_filter import CURRENT_FILTER
from motorid.estimate.effects.reading.current_gain import CURRENT_GAIN
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.effects.reading.driven_current_offset import DRIVEN_CURRENT_OFFSET
from motorid.estimate.effects.reading.motion_gain import MOTION_GAIN
from motorid.estimate.effects.reading.position_origin import POSITION_ORIGIN
from motorid.estimate.effects.reading.speed_filter import SPEED_FILTER
from motorid.estimate.signals.measurements import EMF
from tests.estimate.effects.benches import moved, record, usual


def follows(change: np.ndarray, pattern: np.ndarray) -> float:
    """Correlation of a change (n,) with what it should look like."""
    return float(change @ pattern / np.sqrt((change @ change) * (pattern @ pattern)))


@pytest.mark.parametrize(
    ("bench", "quantity", "shown"),
    [
        ("measured", CURRENT_GAIN, CURRENT),
        ("measured", MOTION_GAIN, POSITION),
        ("moving", MOTION_GAIN, SPEED),
    ],
)
def test_a_gain_is_a_share_of_the_reading(
    bench: str, quantity: InfluenceQuantity, shown: str
) -> None:
    change = moved(bench, quantity)
    assert change[shown] == pytest.approx(usual(bench)[shown], rel=1e-9, abs=1e-12)
    assert not any(part.any() for name, part in change.items() if name != shown)


@pytest.mark.parametrize(
    ("quantity", "shown"), [(CURRENT_OFFSET, CURRENT), (POSITION_ORIGIN, POSITION)]
)
def test_a_zero_adds_to_every_reading_alike(quantity: InfluenceQuantity, shown: str) -> None:
    change = moved("measured", quantity)
    assert change[shown] == pytest.approx(1.0)
    assert not any(part.any() for name, part in change.items() if name != shown)


@pytest.mark.parametrize(
    ("bench", "quantity", "shown"),
    [("measured", CURRENT_FILTER, CURRENT), ("moving", SPEED_FILTER, SPEED)],
)
def test_a_slower_filter_lags(bench: str, quantity: InfluenceQuantity, shown: str) -> None:
    """By its time constant's change times the slope, where the signal is smooth."""
    series = usual(bench)[shown]
    slope = np.gradient(series, 1e-4)
    change = moved(bench, quantity)
    smooth = np.abs(np.gradient(slope)) < 0.05 * np.abs(slope).max()
    smooth &= np.abs(slope) > 1e-3 * np.abs(slope).max()
    assert smooth.sum() > 50
    assert follows(change[shown][smooth], -slope[smooth]) > 0.95
    assert not any(part.any() for name, part in change.items() if name != shown)


def test_a_median_of_quiet_readings_starts_the_offset() -> None:
    subject = record("measured")
    prior = CURRENT_OFFSET.prior(subject, 0)
    assert prior is not None
    assert prior.sd == pytest.approx(1e-3)
    assert prior.start == pytest.approx(0.0, abs=1e-6)  # the capture has no offset


def test_what_a_channel_shows_of_a_series() -> None:
    series = np.array([1.0, -2.0, 0.0])
    assert plus(series, 0.5).tolist() == [1.5, -1.5, 0.5]
    assert times(series, 0.5).tolist() == [1.5, -3.0, 0.0]


def test_typical_sizes() -> None:
    subject = record("measured")
    assert scales.extent_of(np.array([3.0, -1.0])) == 4.0
    assert scales.extent_of(np.array([-2.0, -2.0])) == 2.0  # a constant: what it is
    assert scales.extent_of(np.zeros(3)) == 1.0
    assert scales.extent("no such block")(subject) == 1.0
    assert scales.period_s(subject) == pytest.approx(1 / 20e3)
    assert scales.period_s(record("log")) == record("log").timeline.period_s  # without PWM
    angle = usual("measured")[POSITION]
    top = np.abs(np.diff(angle)).max() / 1e-4  # rad/s
    assert 0.8 * top < scales.speed(subject) <= 1.01 * top
    assert scales.least_delay_s(None) == 0.0
    assert scales.least_delay_s(subject.block(CURRENT)) == pytest.approx(-5e-6)  # 10 µs, 5 filter
    assert scales.least_delay_s(subject.block(EMF)) == 0.0


def test_a_zero_while_driven_adds_to_no_reading_with_the_bridge_open() -> None:
    change = moved("measured", DRIVEN_CURRENT_OFFSET)
    block = record("measured").block(CURRENT)
    assert block is not None
    assert change[CURRENT] == pytest.approx(record("measured").driven[block.keep].astype(float))
    assert 0.0 < change[CURRENT].mean() < 1.0
