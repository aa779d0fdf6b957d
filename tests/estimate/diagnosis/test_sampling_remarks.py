"""A log sampled too slowly, or stamped by another clock, is said to be."""

from __future__ import annotations

import numpy as np
import pytest

from bench.foreign.plant import Motor, turn
from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis import sampling_remarks
from motorid.identify import fit

MOTOR = Motor()
TRUE = turn(MOTOR, lambda t, w: 6.0 if 0.1 < t < 0.5 else 0.0, 0.8)
NOISE = {VOLTAGE: 0.01, CURRENT: 5e-3, SPEED: 0.1}


def codes(period_s: float, late_s: float = 0.0) -> set[str]:
    rng = np.random.default_rng(0)
    stamps = np.arange(1e-3, 0.79, period_s)
    volts = TRUE.at(TRUE.volts, stamps - late_s)
    series = {VOLTAGE: volts, CURRENT: TRUE.at(TRUE.current, stamps),
              SPEED: TRUE.at(TRUE.speed, stamps)}  # fmt: skip
    channels = {
        name: Channel(name, unit, y + NOISE[name] * rng.standard_normal(len(y)))
        for (name, y), unit in zip(series.items(), ("V", "A", "rad/s"), strict=True)
    }
    capture = Capture(np.rint(stamps * 1e6).astype(np.int64), 1e6, channels)
    return {d.code for d in fit([capture]).diagnostics}


@pytest.mark.slow
def test_few_readings_a_motion_and_a_late_voltage_are_said() -> None:
    assert sampling_remarks.FEW * 15e-3 > 40e-3  # of the motor's mechanical time constant
    assert "few_samples" in codes(15e-3)
    late = codes(2e-3, 20e-3)
    assert "delay_beyond_prior" in late
    assert not {"few_samples", "delay_beyond_prior"} & codes(2e-3)
