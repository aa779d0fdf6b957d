"""Residuals that repeat with the angle, made to repeat so many times a turn."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.capture.model import CURRENT
from motorid.estimate.model.angle_spectrum import (
    MOST,
    PEAK,
    Turned,
    _stands,
    periods_a_turn,
    recurring,
    turned,
)
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.exact_capture import FAULHABER, Plan, clean_capture

N = 6000


def channel(*counts: int, noise: float = 0.3, seed: int = 1) -> Turned:
    angle = np.linspace(0.0, 40 * np.pi, N)
    wave = sum((np.sin(n * angle + n) for n in counts), np.zeros(N))
    step = np.full(N, angle[1] - angle[0])
    return Turned(wave + np.random.default_rng(seed).normal(0.0, noise, N), angle, step)


@pytest.mark.parametrize("count", [3, 7, 12, 44])
def test_a_count_is_found(count: int) -> None:
    assert periods_a_turn([[channel(count)]])[0] == count


def test_two_counts_are_found_the_stronger_first() -> None:
    one = channel(5)
    both = Turned(2.0 * one.residual + channel(21).residual, one.angle, one.step)
    assert periods_a_turn([[both]])[:2] == [5, 21]


def test_noise_repeats_at_no_count() -> None:
    assert not any(periods_a_turn([[channel(seed=seed)]]) for seed in range(20))


def test_what_a_sample_steps_over_is_not_told() -> None:
    """A period that passes within a sample or two may be any other."""
    fast = channel(30)
    assert periods_a_turn([[Turned(fast.residual, fast.angle, np.full(N, 2.5 / 30))]]) == []


def test_of_a_residual_only_what_repeats_is_left() -> None:
    angle = np.linspace(0.0, 60.0, 6000)
    period = 2 * np.pi / 7
    wave = np.cos(7 * angle)
    left = recurring(wave + 3.0 + 0.2 * angle, np.arange(6000), angle, period)
    inside = (angle >= period) & (angle <= angle[-1] - period)
    assert left == pytest.approx(wave[inside], abs=1e-3)


def test_of_a_run_half_a_turn_at_each_end_is_left_out() -> None:
    """The mean over a turn is not known there, so that nothing tells what repeats."""
    record = MotorRecord(clean_capture(FAULHABER, Plan(count=800)), PARAMETERS, {})
    angle = np.linspace(0.0, 10 * np.pi, record.timeline.count)
    current = next(m for m in record.measured if m.block.name == CURRENT)
    waves = [np.sin(7 * angle[m.keep]) + 4.0 for m in record.measured]
    longest = max(turned(record, waves, angle), key=lambda one: len(one.angle))
    shown = angle[current.keep]
    assert longest.angle[0] == pytest.approx(shown[0] + np.pi, abs=0.1)
    assert longest.angle[-1] == pytest.approx(shown[-1] - np.pi, abs=0.1)
    assert longest.residual == pytest.approx(np.sin(7 * longest.angle), abs=0.05)


def test_about_a_rest_nothing_repeats() -> None:
    """A rotor that turns, rests and turns back: a period at every end of a motion is left out."""
    path = np.linspace(0.0, 10.0, 1000)
    angle = np.concatenate([path, np.full(300, 10.0), path[::-1]])
    left = recurring(np.cos(angle), np.arange(len(angle)), angle, period=2.0)
    assert len(left) == pytest.approx(2 * 600, abs=8)


@pytest.mark.parametrize(("without", "rows"), [(2, 1), (200, 2)])
def test_a_channel_may_show_some_stretches_of_a_motion_alone(without: int, rows: int) -> None:
    """As an open bridge shows coasts: at both ends of each row of readings a period is left out,
    and a reading or two that are lost end no row.
    """
    angle = np.linspace(0.0, 60.0, 6000)
    keep = np.concatenate([np.arange(1000, 2500), np.arange(2500 + without, 4000)])
    period = 2 * np.pi / 7
    left = recurring(np.cos(7 * angle[keep]) + 0.5, keep, angle, period)
    shown = len(keep) - rows * 2 * period * 6000 / 60.0
    assert len(left) == pytest.approx(shown, abs=2 * rows + 1)
    assert np.abs(left).max() == pytest.approx(1.0, abs=0.02)
    assert left[0] == pytest.approx(np.cos(7 * (angle[1000] + period)), abs=0.1)


@pytest.mark.parametrize(
    ("level", "peak", "stands"),
    [(1.0, 14.9, False), (1.0, 15.1, True), (20.0, 79.0, False), (20.0, 81.0, True)],
)
def test_a_count_stands_out_of_noise_and_of_its_neighbours(
    level: float, peak: float, stands: bool
) -> None:
    """By 15 of what noise gives, and by four times the middle of eight on either side."""
    for count in (1, 30, MOST):
        power = np.full(MOST + 1, level)
        power[0], power[count] = 0.0, peak
        found = np.flatnonzero(_stands(power, PEAK)).tolist()
        assert found == ([count] if stands else [])
    wide = np.where(np.abs(np.arange(MOST + 1) - 30) <= 4, 81.0, 20.0)  # nine of seventeen
    assert not _stands(wide, PEAK).any()
