"""What a noisy level leaves open, against its own statistics."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import SUPPLY, Capture, Channel
from motorid.estimate.effects.reference.temperature import (
    AMBIENT_TEMPERATURE,
    COPPER_COEFFICIENT,
    MAGNET_COEFFICIENT,
    SELF_HEATING,
)
from motorid.estimate.effects.source_noise import SourceNoise
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.program import StepKind
from tests.estimate.effects.benches import POINT, record


def noise() -> SourceNoise:
    one = record("noisy_source")
    return SourceNoise(one.capture, one.timeline, one.sensed)


def test_a_mean_of_n_readings_is_known_to_its_root() -> None:
    """0.05 V of noise on every reading of a level, from a converter of 0.01 V a step."""
    one = record("noisy_source")
    for k in noise().levels:
        count = one.timeline.parts[k].stop - one.timeline.parts[k].start - HEAD
        expected = np.hypot(0.05 / np.sqrt(count), 0.005)
        assert noise().level_deviation(k, None) == pytest.approx(expected, rel=0.15)


def test_a_jitter_moves_a_coast_by_what_the_motor_lets_through() -> None:
    """White steps of V/K, averaged by a lag of τ: V/K √(h/2τ)."""
    (coast,) = noise().coasts
    R, _, K, B, J = POINT[:5]
    tau_s = J * R / (K**2 + R * B)
    period_s = record("noisy_source").timeline.period_s
    expected = 0.05 / K * np.sqrt(period_s / (2 * tau_s))
    assert noise().speed_deviation(coast, None, POINT) == pytest.approx(expected, rel=0.25)


def test_an_exact_level_leaves_nothing_open() -> None:
    assert given([IDLE, DRIVEN], loud(0.0, 0.0)).levels == ()


def test_temperatures_act_on_no_reading() -> None:
    for quantity in (AMBIENT_TEMPERATURE, SELF_HEATING, COPPER_COEFFICIENT, MAGNET_COEFFICIENT):
        assert quantity.acts == ()
        assert quantity.prior(record("diodes"), 0) is None


# parts that are given


def given(
    parts: list[Part], volts: np.ndarray, emf: bool = True, commanded: bool = False,
    supply: np.ndarray | None = None, bend: float = 0.0,
) -> SourceNoise:  # fmt: skip
    line = Timeline(1e-4, len(volts), np.arange(len(volts)), tuple(parts), 0.0)
    sensed: Any = SimpleNamespace(
        volts=volts, shows_emf=emf, commanded=commanded, level_uncertainty=bend
    )
    channels = {} if supply is None else {SUPPLY: Channel(SUPPLY, "V", supply)}
    return SourceNoise(Capture(np.arange(len(volts)) * 100, 1e6, channels), line, sensed)


N = 4000
IDLE, DRIVEN = Part(0, N, StepKind.COAST), Part(N, 2 * N, StepKind.DRIVE_DUTY, 0.5)


def loud(idle: float, driven: float) -> np.ndarray:
    rng = np.random.default_rng(3)
    return np.r_[idle * rng.standard_normal(N), 6.0 + driven * rng.standard_normal(N)]


def test_the_voltage_jumps_by_what_it_scatters_more_than_when_open() -> None:
    noise = given([IDLE, DRIVEN], loud(0.03, 0.05))
    assert noise._jitter(1, None) == pytest.approx(0.04, rel=0.05)
    assert given([IDLE, DRIVEN], loud(0.03, 0.05), emf=False)._jitter(1, None) == pytest.approx(
        0.05, rel=0.05
    )
    alone = given([Part(0, N, StepKind.BRAKE), DRIVEN], loud(0.03, 0.05))
    assert alone._jitter(1, None) == pytest.approx(0.05, rel=0.05)


def test_readings_that_scatter_as_much_when_open_may_hide_a_tenth_of_their_variance() -> None:
    noise = given([IDLE, DRIVEN], loud(0.05, 0.05))
    assert noise._jitter(1, None) == pytest.approx(np.sqrt(0.1) * 0.05, rel=0.05)


def test_however_often_it_is_read_a_level_is_known_no_better_than_its_converter_is_straight() -> (
    None
):
    noise = given([IDLE, DRIVEN], loud(0.0, 0.05), bend=0.01)
    assert noise.level_deviation(1, None) == pytest.approx(0.01, rel=0.01)  # 0.05 V/root(4000) less
    exact = given([IDLE, DRIVEN], loud(0.0, 0.0), bend=0.01)
    assert exact.levels == (1,)
    assert exact.level_deviation(1, None) == 0.01
    idle_again = Part(2 * N, 3 * N, StepKind.COAST)
    still = given([IDLE, DRIVEN, idle_again], np.r_[loud(0.0, 0.0), np.zeros(N)], bend=0.01)
    assert still.coasts == ()  # what does not scatter does not jitter
    short = given([IDLE, replace(DRIVEN, stop=N + HEAD + 2)], loud(0.0, 0.0), bend=0.01)
    assert short.levels == ()


def test_a_source_that_was_told_says_what_it_scatters_by() -> None:
    source: Any = SimpleNamespace(noise=0.07)
    noise = given([IDLE, DRIVEN], loud(0.0, 0.05))
    assert noise._noise(1, source) == 0.07
    assert noise._noise(1, None) == pytest.approx(0.05, rel=0.05)
    short = given([IDLE, replace(DRIVEN, stop=N + HEAD + 2)], loud(0.0, 0.05))
    assert short._noise(1, None) == 0.0


def test_commanded_volts_scatter_as_the_supply_that_they_are_made_by() -> None:
    volts = Part(N, 2 * N, StepKind.DRIVE_VOLTS, -6.0)
    rng = np.random.default_rng(4)
    supply = 12.0 + 0.1 * rng.standard_normal(2 * N)
    noise = given([IDLE, volts], loud(0.0, 0.0), commanded=True, supply=supply)
    assert noise._noise(1, None) == pytest.approx(6.0 * 0.1 / 12.0, rel=0.05)
    unknown = given([IDLE, volts], loud(0.0, 0.5), commanded=True)
    assert unknown._noise(1, None) == 0.0
    measured = given([IDLE, volts], loud(0.0, 0.5), supply=supply)
    assert measured._noise(1, None) == pytest.approx(0.5, rel=0.05)
