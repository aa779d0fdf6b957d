"""The voltage of a log at its edges and limits: another period, jumps that are hardly any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import VOLTAGE
from motorid.estimate.signals.intersample_voltage import (
    BROKEN,
    JOINED,
    LOOSE,
    MOST_JUMPS,
    Shape,
    Waveform,
    of_log,
)
from motorid.estimate.signals.voltage_jumps import least_jump, scatter
from motorid.program import Program, Step, StepKind
from tests.estimate.signals.test_readings_of_a_log import grid, log

Floats = NDArray[np.float64]
SLOW_S = 2.0  # a usual period that is not one


def wave(volts: Floats, shape: Shape = BROKEN, time_s: Floats | None = None) -> Waveform:
    stamps = SLOW_S * np.arange(len(volts)) if time_s is None else time_s
    return Waveform(stamps, np.asarray(volts, float), shape, SLOW_S)


def test_a_joined_voltage_reaches_from_its_first_reading_to_its_last() -> None:
    """Before it and after it the voltage stays; the last line counts."""
    shown = wave(np.array([1.0, 3.0, 9.0]), JOINED)
    assert shown._slopes.tolist() == [1.0, 3.0, 0.0]
    times = shown.within(np.array([-3.0, 0.0, 2.0, 4.0, 4.5]))
    assert shown._flux(times) == pytest.approx([-3.0, 0.0, 4.0, 16.0, 16.0 + 4.5])
    times = shown.within(np.array([0.5, 3.0, 4.0]))
    assert shown._value(times) == pytest.approx([1.5, 6.0, 9.0])
    assert (shown.window_s, shown.ohms) == (0.0, 0.0)


def test_behind_a_low_pass_the_first_and_the_last_line_were_ahead_too() -> None:
    """3 V/s, which a time constant of .5 s makes 1.5 V more; before it and after it, nothing."""
    shown = wave(3.0 * SLOW_S * np.arange(6.0), JOINED)
    means = shown.means(grid(8, SLOW_S), 0.0, (), 0.5)
    assert means[1:6] == pytest.approx(6.0 * (np.arange(1, 6) - 0.5) + 1.5)
    assert means[[0, 6, 7]] == pytest.approx([0.0, 30.0, 30.0])


def test_two_readings_that_lie_close_tell_no_slope() -> None:
    """A tenth of the usual period is the least."""
    stamps = np.array([0.0, 2.0, 2.01, 4.0])
    shown = wave(np.array([0.0, 0.0, 1.0, 1.0]), JOINED, stamps)
    assert shown._slopes == pytest.approx([0.0, 1.0 / 0.2, 0.0, 0.0])
    held = replace(shown, shape="held")._before_filter(0.3)
    assert held == pytest.approx([0.0, 0.0, 1.0 + 1.0 / np.expm1(0.2 / 0.3), 1.0])


@pytest.mark.parametrize(("drift", "wanders"), [(0.4, False), (0.6, True)])
def test_a_voltage_wanders_by_more_than_a_twentieth_of_its_range(
    drift: float, wanders: bool
) -> None:
    """Of 10 V, without noise."""
    volts = np.concatenate([np.linspace(0.0, drift, 20), np.full(20, 10.0)])
    shown = wave(volts)
    assert shown.steps_off.tolist() == [20]
    assert shown.wanders is wanders


def test_a_voltage_without_a_jump_wanders_where_it_is_no_constant() -> None:
    """As of a motor that coasts: what is held between readings is half a sample late."""
    assert wave(np.linspace(0.0, 10.0, 60)).wanders is True
    noise = 0.01 * np.random.default_rng(0).standard_normal(400)
    assert wave(10.0 + noise).wanders is False
    assert wave(np.linspace(0.0, 10.0, 400) + noise).wanders is True


@pytest.mark.parametrize(("by_turns", "found"), [(0.05, [100]), (0.16, [100]), (0.19, [])])
def test_a_jump_is_eight_deviations_high(by_turns: float, found: list[int]) -> None:
    """Readings that are a off by turns scatter by 1.63 a, and by some more in the stretch that has
    the jump; a quarter of normal ones that differ by 2 a would by 4.4 a: the less counts. They jump
    by 2 V + 2 a, which is noise from .17 V on.
    """
    volts = np.where(np.arange(200) < 100, 0.0, 2.0) + by_turns * (-1.0) ** np.arange(200)
    usual = by_turns * 4.0 / np.sqrt(6.0)
    assert 0.999 * usual < scatter(volts) < 1.1 * usual
    assert least_jump(volts) == pytest.approx(8.0 * scatter(volts))
    assert wave(volts).steps_off.tolist() == found


def test_stamps_are_irregular_beside_the_usual_period() -> None:
    volts, stamps = np.repeat([0.0, 6.0, 2.0], 8), SLOW_S * np.arange(24.0)
    assert wave(volts, "held", stamps).jumps.tolist() == []
    stamps[8:] += 0.1 * SLOW_S
    assert wave(volts, "held", stamps).jumps.tolist() == [8]


def test_where_jumps_are_too_many_those_of_least_voltage_and_time_are_left() -> None:
    """One of 1.5 V over three periods says more than one of 1.2 V, and than 2 V over one."""
    rises = np.full(MOST_JUMPS + 1, 2.0)
    rises[3], rises[7] = 1.5, 1.2
    levels = np.concatenate([[0.0], np.cumsum(rises * (-1.0) ** np.arange(len(rises)))])
    steps = np.full(4 * len(levels), SLOW_S)
    steps[4 * 4 - 1] *= 3.0  # before the fourth jump
    stamps = np.concatenate([[0.0], np.cumsum(steps)[:-1]])
    found = wave(np.repeat(levels, 4), LOOSE, stamps).jumps.tolist()
    assert len(found) == MOST_JUMPS
    assert 4 * 4 in found
    assert 4 * 8 not in found


def test_a_program_without_its_phases_is_a_log() -> None:
    capture = log(np.arange(20.0))
    lone = replace(capture, program=Program((Step(StepKind.COAST, 1.0),)))
    assert of_log(lone, lone.channels[VOLTAGE], JOINED) is not None
    twice = log(np.r_[1.0, np.full(10, np.nan), 2.0])
    found = of_log(twice, twice.channels[VOLTAGE], JOINED)
    assert found is not None
    assert found.volts.tolist() == [1.0, 2.0]
