"""Where searches begin: grids that reach over what they must find, without holes.

A search ends at the truth if it begins near enough. So whatever the truth is within the span of a
grid, one of its values is no farther from it than half a step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest

from motorid.estimate.diagnosis import foreign_voltage
from motorid.estimate.diagnosis.facts.pwm import frequency
from motorid.estimate.diagnosis.faults import (
    channel_delay,
    load_slip,
    lost_rows,
    saturation,
)
from motorid.estimate.diagnosis.faults.filters import low_pass_filter
from motorid.estimate.fit import (
    joint_fit,
    lagging_start,
    multistart,
    start_values_without_motion,
    subsample_inductance,
)
from motorid.estimate.fit.logs import log_lags, log_second_order, log_shapes, smoothed_voltage
from motorid.estimate.selection import shaft_resonance
from motorid.estimate.signals import voltage_smoothing
from motorid.estimate.signals.source import smoothing

GRIDS = {  # values; the span to cover; the largest ratio between neighbours
    "lag of a motion over its guess": (joint_fit.TRIED, 0.5, 2.0, 1.5),
    "samples of a motion's lag": (lagging_start.LAGS, 1.0, 84.0, 2.0),
    "L/R in samples behind a low-pass": (smoothed_voltage.RISES, 0.3, 3.0, 3.5),
    "L/R in samples of a log": (log_shapes.RISES, 0.4, 4.0, 4.0),
    "L/R in samples without a motion": (start_values_without_motion.TIMES, 0.1, 10.0, 10.0),
    "R of the most that it can be": (start_values_without_motion.SHARES, 0.3, 1.0, 1.4),
    "L/R where the usual start fails": (multistart.RISES, 0.1, 0.3, 3.1),
    "samples of a channel's delay": (channel_delay.SAMPLES, 0.5, 12.0, 4.0),
    "samples of the voltage's delay": (channel_delay.OF_VOLTAGE, 1.0, 8.0, 3.0),
    "samples of a low-pass": (low_pass_filter.SAMPLES, 0.5, 20.0, 4.0),
    "acceleration of a slipping load": (load_slip.RATES, 0.03, 0.9, 1.3),
    "end of a range": (saturation.SHARES, 0.65, 0.97, 1.25),
    "rows of a line": (lost_rows.SIDES, 5.0, 20.0, 2.0),
    "a wrong PWM frequency": (frequency.FACTORS, 0.25, 4.0, 4.0),
    "share of an inertia behind a shaft": (shaft_resonance.SHARES, 0.3, 0.85, 2.0),
    "windows of a smooth voltage": (smoothing.WINDOWS, 4.0, 64.0, 2.0),
    "windows beside a jump": (voltage_smoothing.HALF_WINDOWS, 4.0, 128.0, 2.0),
}


@pytest.mark.parametrize("name", GRIDS)
def test_a_grid_reaches_over_its_span_without_holes(name: str) -> None:
    values, low, high, most = GRIDS[name]
    grid = np.asarray(values, dtype=np.float64)
    steps = grid[1:] / grid[:-1]
    assert (steps > 1.0).all() or (steps < 1.0).all()  # in order: the likelier end comes first
    assert sorted((grid[0], grid[-1])) == pytest.approx([low, high])
    for truth in np.geomspace(low, high, 50):
        off = np.abs(np.log(grid / truth)).min()
        assert off <= 0.5 * math.log(most) + 1e-9, truth


@pytest.mark.parametrize(
    ("values", "most"),
    [(foreign_voltage.LAGS, 50), (log_lags.BESIDE, 1), (channel_delay.AROUND, 0.3)],
    ids=["lags of a foreign voltage", "beside a lag", "about a delay"],
)
def test_late_and_early_are_tried_alike_and_neither_first(
    values: Sequence[float], most: float
) -> None:
    assert values[0] == 0
    assert set(values) == {-one for one in values}
    assert max(values) == most


def test_frequencies_about_a_peak_lie_on_both_sides() -> None:
    about = np.array(shaft_resonance.ABOUT)
    assert about - 1.0 == pytest.approx(-(about - 1.0)[::-1])
    assert np.diff(about) == pytest.approx(0.01)
    assert about[-1] == pytest.approx(1.02)


def test_a_wrong_frequency_is_tried_both_ways() -> None:
    factors = np.array(frequency.FACTORS)
    assert factors * factors[::-1] == pytest.approx(1.0)


def test_a_second_order_begins_on_either_side_of_two_like_filters() -> None:
    low, high = log_second_order.BENT
    assert 0.0 < low < 0.5 < high < 1.0
    assert low + high == pytest.approx(1.0)


def test_steps_of_a_held_inductance_get_finer_to_the_last() -> None:
    steps = (subsample_inductance.COARSE, *subsample_inductance.FINER)
    assert steps[-1] == 1
    for wide, narrow in pairwise(steps):
        assert wide / 2 <= narrow + 1 <= wide + 0.5  # halved, and no place is passed over
        assert narrow < wide
