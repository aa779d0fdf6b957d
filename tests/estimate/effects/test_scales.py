"""Typical sizes in a capture, by arithmetic on readings that are given."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED, Channel
from motorid.estimate.effects import scales


def block(name: str, values: np.ndarray, keep: np.ndarray | None = None, **facts: float) -> Any:
    keep = np.arange(len(values)) if keep is None else keep
    channel = Channel(name, "", values, **facts)
    return SimpleNamespace(
        block=SimpleNamespace(name=name), values=values, keep=keep, channel=channel
    )


def subject(*blocks: Any, **facts: Any) -> Any:
    named = {b.block.name: b for b in blocks}
    return SimpleNamespace(block=named.get, timeline=SimpleNamespace(period_s=0.01), **facts)


@pytest.mark.parametrize(
    ("values", "extent"),
    [([1.0, -2.0, 4.0], 6.0), ([3.0, 3.0], 3.0), ([-3.0, -3.0], 3.0), ([0.0, 0.0], 1.0)],
)
def test_an_extent_is_from_the_least_to_the_most(values: list[float], extent: float) -> None:
    given = np.array(values)
    assert scales.extent_of(given) == extent
    assert scales.extent(CURRENT)(subject(block(CURRENT, given))) == extent
    assert scales.extent(CURRENT)(subject()) == 1.0
    assert scales.volts(subject(sensed=SimpleNamespace(volts=given))) == extent


def test_the_speed_is_the_highest_mean_over_a_twentieth() -> None:
    steady = np.r_[np.zeros(100), -0.3 * np.arange(100.0)]  # rad at every tick of 10 ms
    steady[53] += 5.0  # a single reading that jumps is not looked at
    assert scales.speed(subject(block(POSITION, steady))) == pytest.approx(30.0)
    sparse = np.arange(200) * 2  # every second tick has a reading
    assert scales.speed(subject(block(POSITION, steady, sparse))) == pytest.approx(15.0)
    shown = block(SPEED, np.array([1.0, -7.0, 3.0]))
    assert scales.speed(subject(shown)) == 7.0
    assert scales.speed(subject(shown, block(POSITION, steady))) == pytest.approx(30.0)
    assert scales.speed(subject()) == 0.0
    assert scales.speed(subject(block(POSITION, np.array([2.0])))) == 0.0
    few = subject(block(POSITION, np.array([0.0, 0.1, 0.5])))
    assert scales.speed(few) == pytest.approx(40.0)


def test_what_is_declared_is_a_prior_and_nothing_is_none() -> None:
    prior = scales.declared(CURRENT, "gain_uncertainty")
    found = prior(subject(block(CURRENT, np.zeros(3), gain_uncertainty=0.02)), 0)
    assert found is not None
    assert (found.sd, found.mean, found.start) == (0.02, 0.0, None)
    assert prior(subject(block(CURRENT, np.zeros(3))), 0) is None
    assert prior(subject(), 0) is None


def test_a_reading_comes_after_what_it_shows_but_for_its_filter() -> None:
    later = block(CURRENT, np.zeros(3), delay_s=3e-4, filter_s=1e-4)
    assert scales.least_delay_s(later) == pytest.approx(-2e-4)
    assert scales.least_delay_s(block(CURRENT, np.zeros(3))) == 0.0
    assert scales.least_delay_s(None) == 0.0


def test_the_period_is_that_of_the_pwm_where_there_is_one() -> None:
    assert scales.period_s(subject(pwm_period_s=5e-5)) == 5e-5
    assert scales.period_s(subject(pwm_period_s=0.0)) == 0.01


def test_stall_and_top_speed_are_the_motors_at_the_highest_voltage() -> None:
    motor = np.array([2.0, 1e-3, 0.05, 4e-5, 2e-5, 6e-3])
    driven = subject(volts=np.array([3.0, -8.0]), judged_at=motor, loss=None,
                     sensed=SimpleNamespace(volts=np.array([0.0, 5.0])))  # fmt: skip
    assert scales.stall(driven) == pytest.approx(4.0)
    assert scales.top_speed(driven) == pytest.approx(160.0)
    assert scales.friction(driven) == pytest.approx(6e-3 + 4e-5 * 160.0)
    assert scales.friction(driven, dry=False) == pytest.approx(4e-5 * 160.0)
    assert scales.top_volts(driven) == 5.0
    driven.loss = SimpleNamespace(top_v=9.0)
    assert scales.top_volts(driven) == 9.0
    driven.judged_at = np.array([2.0, 1e-3, 0.05, 0.0, 2e-5, 0.0])
    assert scales.friction(driven) == pytest.approx(1e-3 * 0.05 * 4.0)  # of the stall torque
    driven.volts = np.zeros(0)
    assert scales.stall(driven) == pytest.approx(0.5)  # as of a volt
