"""What a noisy level leaves open, against its own statistics."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.estimate.effects.reference.temperature import (
    AMBIENT_TEMPERATURE,
    COPPER_COEFFICIENT,
    MAGNET_COEFFICIENT,
    SELF_HEATING,
)
from motorid.estimate.effects.source_noise import SourceNoise
from motorid.estimate.signals.step_transient import HEAD
from tests.estimate.effects.benches import POINT, record


def noise() -> SourceNoise:
    one = record("noisy_source")
    return SourceNoise(one.capture, one.timeline, one.sensed)


def test_a_mean_of_n_readings_is_known_to_its_root() -> None:
    """0.05 V of noise on every reading of a level."""
    one = record("noisy_source")
    for k in noise().levels:
        count = one.timeline.parts[k].stop - one.timeline.parts[k].start - HEAD
        assert noise().level_deviation(k, None) == pytest.approx(0.05 / np.sqrt(count), rel=0.25)


def test_a_jitter_moves_a_coast_by_what_the_motor_lets_through() -> None:
    """White steps of V/K, averaged by a lag of τ: V/K √(h/2τ)."""
    (coast,) = noise().coasts
    R, _, K, B, J = POINT[:5]
    tau_s = J * R / (K**2 + R * B)
    period_s = record("noisy_source").timeline.period_s
    expected = 0.05 / K * np.sqrt(period_s / (2 * tau_s))
    assert noise().speed_deviation(coast, None, POINT) == pytest.approx(expected, rel=0.25)


def test_an_exact_level_leaves_nothing_open() -> None:
    one = record("diodes")
    assert SourceNoise(one.capture, one.timeline, one.sensed).levels == ()


def test_temperatures_act_on_no_reading() -> None:
    for quantity in (AMBIENT_TEMPERATURE, SELF_HEATING, COPPER_COEFFICIENT, MAGNET_COEFFICIENT):
        assert quantity.acts == ()
        assert quantity.prior(record("diodes"), 0) is None
