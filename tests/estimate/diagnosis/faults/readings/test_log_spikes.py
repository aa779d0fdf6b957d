"""Speeds of a log that stand far from all around them are left out, and said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.diagnosis.faults.readings import log_spikes

TIME = np.arange(0.0, 4.0, 0.01)
VOLTS = np.repeat([0.0, 8.0, -4.0, 6.0], 100)
NOISE = np.random.default_rng(3).standard_normal(len(TIME))


def motion(volts: np.ndarray = VOLTS) -> np.ndarray:
    out, now = [], 0.0
    for one in volts:
        now += (40.0 * one - now) / 8.0
        out.append(now)
    return np.array(out) + NOISE


def log(speed: np.ndarray, volts: np.ndarray = VOLTS, **more: Channel) -> Capture:
    channels = {VOLTAGE: Channel(VOLTAGE, "V", volts), SPEED: Channel(SPEED, "rad/s", speed)}
    return Capture(np.rint(TIME * 1e9).astype(np.int64), 1e9, {**channels, **more})


def spiked(places: list[int], times: float) -> np.ndarray:
    speed = motion()
    speed[places] *= times
    return speed


@pytest.mark.parametrize(("places", "times"), [([150], 5.0), ([150, 151, 180], -8.0)])
def test_speeds_that_stand_alone_are_left_out(places: list[int], times: float) -> None:
    (cleared,), (said,) = log_spikes.removed([log(spiked(places, times))])
    assert np.flatnonzero(np.isnan(cleared.channels[SPEED].values)).tolist() == places
    assert (said.code, said.strength, said.allowed) == ("spikes", "named", True)
    assert f"{len(places)} reading" in said.evidence or "one reading" in said.evidence


def test_a_log_without_spikes_stays_as_it_is() -> None:
    for speed in (motion(), np.rint(motion() / 20.0) * 20.0):
        one = log(speed)
        assert log_spikes.removed([one]) == ([one], ())


def test_a_pulse_of_the_drive_is_no_spike() -> None:
    volts = np.full(len(TIME), 8.0)
    volts[200:202] = 0.0
    speed = np.where(volts > 0.0, 320.0, 180.0) + NOISE
    assert not log_spikes.find(log(speed, volts)).any()
    assert log_spikes.find(log(speed, np.full(len(TIME), 8.0))).any()


def test_beside_a_current_only_speeds_beyond_all_others_count() -> None:
    current = Channel(CURRENT, "A", NOISE)
    low, high = log(spiked([150], 0.0)), log(spiked([150], 5.0))
    assert log_spikes.find(low)[150]
    for one, found in ((low, False), (high, True)):
        beside = replace(one, channels={**one.channels, CURRENT: current})
        assert log_spikes.find(beside)[150] == found


@pytest.mark.parametrize(("share", "some"), [(0.2, True), (0.3, False)])
def test_readings_of_which_many_are_spikes_stay(share: float, some: bool) -> None:
    places = np.arange(0, len(TIME), round(1.0 / share))
    speed = np.full(len(TIME), 300.0) + NOISE
    speed[places] = 3000.0
    assert log_spikes.find(log(speed, np.full(len(TIME), 8.0))).any() == some


def test_two_counts_less_than_usual_are_no_spike() -> None:
    """Ten counts an interval, now and then nine, once eight: a fifth of the range."""
    counts = np.where(np.arange(len(TIME)) % 4, 10.0, 9.0)
    counts[:100] = 0.0
    counts[200] = 8.0
    assert not log_spikes.find(log(5.2 * counts)).any()
    counts[200] = 18.0
    assert np.flatnonzero(log_spikes.find(log(5.2 * counts))).tolist() == [200]
