"""Quantities by which a channel was smoothed, and the noise that one hides of its own channel."""

from __future__ import annotations

import pytest

from motorid.capture.model import CURRENT, SPEED
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.reading.smoothing import SMOOTHED, hidden_noise
from motorid.estimate.effects.reading.smoothing_kernels import SMOOTHINGS, Smoothing, hidden
from motorid.estimate.solver.problem import Unknown


@pytest.mark.parametrize("way", SMOOTHINGS)
def test_a_channels_noise_is_hidden_by_its_own_smoothing(way: Smoothing) -> None:
    one = Instance(SMOOTHED[CURRENT][way])
    for size, order, expected in ((4.0, 1, hidden(way.kernel(4.0), 1)), (0.0, 2, 1.0)):
        assert hidden_noise([one], [Unknown(one.name, size)], CURRENT, order) == expected
    assert hidden_noise([one], [Unknown(one.name, 4.0)], SPEED) == 1.0
    assert hidden_noise([], [], CURRENT) == 1.0


def test_every_way_is_a_quantity_of_both_channels() -> None:
    names = [f"{channel} behind {way.how}" for channel in (CURRENT, SPEED) for way in SMOOTHINGS]
    assert [one.name for ways in SMOOTHED.values() for one in ways.values()] == names
