"""What few conversions miss of a filtered PWM voltage, against the sampled waveform itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import VOLTAGE, Channel
from motorid.estimate.effects.source.sampling_phases import deviation

PERIOD_S, SWING_V = 50e-6, 24.0


def mean_error(duty: float, offset: float, count: int, filter_s: float) -> float:
    """V by which the mean of ``count`` conversions differs from that of the wave itself."""
    at = (np.arange(count) + offset) / count * PERIOD_S
    on = duty * PERIOD_S
    rise, fall = np.exp(-on / filter_s), np.exp(-(PERIOD_S - on) / filter_s)
    low = fall * (1.0 - rise) / (1.0 - rise * fall)
    high = 1.0 - (1.0 - low) * rise
    rising = 1.0 - (1.0 - low) * np.exp(-at / filter_s)
    falling = high * np.exp(-(at - on) / filter_s)
    return float(SWING_V * (np.where(at < on, rising, falling).mean() - duty))


@pytest.mark.parametrize(("count", "filter_s"), [(25, 12.5e-6), (25, 30e-6), (8, 25e-6)])
def test_the_deviation_is_that_of_sampled_waves(count: int, filter_s: float) -> None:
    rng = np.random.default_rng(1)
    drawn = [mean_error(*rng.uniform((0.2, 0.0), (0.9, 1.0)), count, filter_s) for _ in range(3000)]
    channel = Channel(
        VOLTAGE, "V", np.zeros(1), kind="mean", filter_s=filter_s, pwm_phase=1.0 / count
    )
    assert deviation(channel, SWING_V, PERIOD_S) == pytest.approx(np.std(drawn), rel=0.1)
    for other in ({"pwm_phase": None}, {"kind": "instant"}, {"filter_s": 0.0}):
        assert deviation(replace(channel, **other), SWING_V, PERIOD_S) == 0.0
