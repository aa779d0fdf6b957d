"""When a model explains too little of a channel for any answer."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, SPEED
from motorid.estimate.model import unexplained
from motorid.estimate.model.unexplained import Unexplained
from motorid.estimate.signals.measurements import EMF


@pytest.mark.parametrize(
    ("one", "contradicts"),
    [
        (Unexplained(CURRENT, 0.4, 0.26, False), True),
        (Unexplained(CURRENT, 0.4, 0.24, False), False),
        (Unexplained(CURRENT, 0.91, 0.0, False), True),  # it shows nothing of the motor
        (Unexplained(CURRENT, 0.89, 0.0, False), False),
        (Unexplained(SPEED, 0.51, 0.0, False), True),
        (Unexplained(SPEED, 0.49, 0.0, False), False),
        (Unexplained(SPEED, 0.99, 0.9, False, made=0.9e-3), False),  # a rotor at rest
        (Unexplained(SPEED, 0.99, 0.9, False, made=1.1e-3), True),
        (Unexplained(CURRENT, 0.99, 0.9, False, made=0.0), True),  # a current is not
        (Unexplained(CURRENT, 0.99, 0.9, True), False),  # its channel declares as much
    ],
)
def test_limits(one: Unexplained, contradicts: bool) -> None:
    assert one.contradicts is contradicts


def record(
    name: str, values: np.ndarray, noise: float = 0.0, resolution: float = 0.0, volts: float = 0.0
) -> Any:
    block = SimpleNamespace(name=name)
    m = SimpleNamespace(block=block, values=values, noise=noise, resolution=resolution)
    return SimpleNamespace(
        measured=[m], volts=np.full(10, volts), driven=np.ones(10, dtype=bool),
        departures=lambda _values, own: own, sensed=SimpleNamespace(waveform=None),
        timeline=SimpleNamespace(jitter=0.0),
    )  # fmt: skip


def of(one: Any, left: np.ndarray) -> Unexplained:
    solution: Any = SimpleNamespace(values=None, own=[[left]])
    (found,) = unexplained.unexplained([one], solution)
    return found


def test_shares_are_of_the_mean_square() -> None:
    t = np.linspace(0, 20, 2000)
    shown, left = 3 * np.sin(t), 0.6 * np.cos(t / 3)  # smooth: no noise of neighbours
    found = of(record(CURRENT, shown), left)
    share = float(left @ left / (shown @ shown))
    assert found.share == pytest.approx(share)
    assert found.beyond == pytest.approx(share, rel=1e-3)
    made = shown - left
    assert found.made == pytest.approx(float(made @ made / (shown @ shown)))
    assert not found.declared


def test_noise_of_neighbours_is_no_contradiction() -> None:
    rng = np.random.default_rng(1)
    found = of(record(CURRENT, np.ones(4000)), 0.8 * rng.normal(size=4000))
    assert found.share == pytest.approx(0.64, rel=0.1)
    assert found.beyond == pytest.approx(0.0, abs=0.05)


def test_declared_noise_counts_twice_itself() -> None:
    left = np.full(100, 0.5)  # smooth
    found = of(record(CURRENT, np.ones(100), noise=0.2), left)
    assert found.beyond == pytest.approx(0.25 - 4 * 0.04)
    assert not found.declared
    assert of(record(CURRENT, np.ones(100), noise=0.26), left).declared
    assert of(record(CURRENT, np.ones(100), resolution=0.9), left).declared  # √12 of a step
    assert not of(record(CURRENT, np.ones(100), resolution=0.8), left).declared


def test_a_position_has_no_zero() -> None:
    t = np.linspace(0, 1, 100)
    near, far = (of(record(POSITION, t + zero), 0.1 * t) for zero in (0.0, 1e3))
    assert near.share == pytest.approx(far.share)


def test_a_back_emf_is_compared_with_what_drove_the_motor() -> None:
    left = np.full(100, 0.1)
    alone, beside = (of(record(EMF, np.full(100, 0.1), volts=v), left) for v in (0.0, 10.0))
    assert alone.share == pytest.approx(1.0)
    assert beside.share == pytest.approx(1e-4)


def test_a_channel_of_zeros_says_nothing() -> None:
    assert not of(record(CURRENT, np.zeros(50)), np.zeros(50)).contradicts


def test_the_worst_channel_is_named_and_none_of_stamps_that_jump() -> None:
    bad = record(CURRENT, np.ones(100))
    solution: Any = SimpleNamespace(values=None, own=[[np.linspace(-1.5, 1.5, 100)]])
    found = unexplained.unsupported([bad], solution)
    assert found is not None
    assert found.channel == CURRENT
    bad.sensed.waveform, bad.timeline.jitter = object(), 0.5
    assert unexplained.unsupported([bad], solution) is None


def test_one_log_whose_stamps_jump_is_enough_to_say_nothing() -> None:
    """Of several; stamps of a board may jump as they do."""
    left = np.linspace(-1.5, 1.5, 100)
    solution: Any = SimpleNamespace(values=None, own=[[left], [left]])
    runs = [record(CURRENT, np.ones(100)), record(CURRENT, np.ones(100))]
    assert unexplained.unsupported(runs, solution) is not None
    runs[0].timeline.jitter = 0.5
    assert unexplained.unsupported(runs, solution) is not None
    runs[0].sensed.waveform = object()
    assert unexplained.unsupported(runs, solution) is None
    runs[0].timeline.jitter = unexplained.IRREGULAR
    assert unexplained.unsupported(runs, solution) is not None


def test_only_a_back_emf_is_compared_with_what_drove_the_motor() -> None:
    """By the voltage while it was driven."""
    left = np.full(100, 0.1)
    assert of(record(CURRENT, np.full(100, 0.1), volts=10.0), left).share == pytest.approx(1.0)
    part = record(EMF, np.full(100, 0.1), volts=10.0)
    part.driven = np.arange(10) < 4
    part.volts = np.where(part.driven, 2.0, 50.0)
    assert of(part, left).share == pytest.approx(0.01 / 4.0)
    still = record(EMF, np.full(100, 0.1), volts=10.0)
    still.driven = np.zeros(10, dtype=bool)
    assert of(still, left).share == pytest.approx(1.0)


def test_runs_of_a_channel_count_together() -> None:
    """By the sums of their squares, each channel for itself."""
    solution: Any = SimpleNamespace(values=None, own=[[np.full(10, 1.0)], [np.full(30, 2.0)]])
    runs = [record(CURRENT, np.full(10, 4.0)), record(CURRENT, np.full(30, -8.0))]
    (found,) = unexplained.unexplained(runs, solution)
    assert found.share == pytest.approx((10.0 + 30 * 4.0) / (160.0 + 30 * 64.0))
    made = (10 * 9.0 + 30 * 100.0) / (160.0 + 30 * 64.0)
    assert found.made == pytest.approx(made)
    runs[1].measured[0].block.name = SPEED
    assert [one.channel for one in unexplained.unexplained(runs, solution)] == [CURRENT, SPEED]


def test_a_speed_of_counts_is_judged_by_means() -> None:
    """Most readings are none and some a whole count: each by itself shows little of the motor."""
    rng = np.random.default_rng(2)
    likely = 0.2 + 0.1 * np.sin(np.linspace(0, 20, 4000))  # of a count in a reading
    counts = (rng.random(4000) < likely).astype(float)
    left = counts - likely
    assert float(left @ left) > 0.7 * float(counts @ counts)
    assert not of(record(SPEED, counts), left).contradicts
    assert of(record(SPEED, counts), counts - np.roll(likely, 1000) + 0.5).contradicts
    assert of(record(CURRENT, counts), left).share > 0.7  # of a current each reading counts
