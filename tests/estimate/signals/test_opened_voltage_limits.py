"""After how many samples an opened bridge shows the back-EMF, by the last ramp of its current."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, VOLTAGE, Channel
from motorid.estimate.signals import opened_voltage as module
from motorid.estimate.signals.opened_voltage import LONG, SAMPLES, emf_shows
from motorid.estimate.signals.time_grid import Part, Timeline, lay
from motorid.program import StepKind
from tests.estimate.signals.test_time_grid import COAST, capture, drive

Floats = NDArray[np.float64]
PERIOD_S = 1e-3
VOLTS = Channel(VOLTAGE, "V", np.zeros(1))


def stopped(amperes: Floats, volts: Channel = VOLTS, **facts: float | str) -> int:
    """Of a current (n,) that is shown from the opening on."""
    count = len(amperes)
    part = Part(0, count, StepKind.COAST)
    line = Timeline(PERIOD_S, count, np.arange(count), (part,), 0.0)
    current = Channel(CURRENT, "A", amperes, **facts)
    return module._stopped(current, line, part, volts)


RAMP = np.append([1.0, 0.8, 0.6, 0.4, 0.2], np.zeros(35))


@pytest.mark.parametrize(
    ("quiet_a", "window_s", "hidden_s"),
    [
        (0.01, 0.0, 0.01 / 500.0),
        (0.01, 1e-3, math.sqrt(2.0 * 0.01 * 1e-3 / 500.0)),  # within the window
        (0.2, 1e-3, math.sqrt(2.0 * 0.2 * 1e-3 / 500.0)),
        (0.3, 1e-3, 0.3 / 500.0 + 0.5e-3),  # slope window / 2 is .25 A
        (2.0, 1e-3, 2.0 / 500.0 + 0.5e-3),
    ],
)
def test_a_ramp_hides_below_what_is_quiet(quiet_a: float, window_s: float, hidden_s: float) -> None:
    """From half of 3 A in three samples: 500 A/s."""
    falling = np.array([3.0, 2.7, 1.5, 1.2, 0.4])
    found = module._hidden_s(falling, quiet_a, window_s, PERIOD_S)
    assert found == pytest.approx(hidden_s)


def test_the_ramp_is_that_after_the_last_reading_of_half_the_peak() -> None:
    falling = np.array([0.2, 2.0, 0.6, 1.1, 0.3])
    assert module._hidden_s(falling, 0.05, 0.0, PERIOD_S) == pytest.approx(0.05 / 500.0)


def test_a_channel_begins_to_look_before_its_stamp() -> None:
    mean = Channel(VOLTAGE, "V", np.zeros(1), kind="mean", aperture_s=2e-3, delay_s=3e-3)
    assert module._oldest_s(mean) == pytest.approx(5e-3)


def test_instants_show_the_end_of_a_current_as_it_comes() -> None:
    assert stopped(RAMP) == 5
    assert stopped(RAMP, replace(VOLTS, delay_s=4e-3)) == 9
    assert stopped(RAMP, replace(VOLTS, delay_s=4e-3), delay_s=4e-3) == 5
    assert stopped(RAMP, delay_s=4e-3) == 5  # a voltage that comes earlier is not taken earlier
    wide = Channel(VOLTAGE, "V", np.zeros(1), kind="mean", aperture_s=3e-3)
    assert stopped(RAMP, wide) == 8
    assert stopped(RAMP, replace(VOLTS, filter_s=1e-3)) == 12  # seven time constants


def test_what_the_resolution_hides_is_waited_for() -> None:
    """Five quanta of .05 A, at 1 A in 6 ms from half of it: 1.5 ms."""
    assert stopped(RAMP, resolution=0.05) == 4 + math.ceil(0.25 / (0.5 / 2e-3) / 1e-3)


@pytest.mark.parametrize(("more", "samples"), [(0, 5), (-1, 0)])
def test_the_second_half_of_thirty_two_samples_shows_the_zero(more: int, samples: int) -> None:
    assert stopped(RAMP[: LONG + more] + 0.3) == samples


def test_a_current_without_an_end_is_unclear() -> None:
    """Three in a row without one are its end."""
    again = np.where(np.arange(60) % 3 == 0, 2.0, 0.0)
    assert stopped(again) == 0
    assert stopped(np.where(np.arange(60) % 4 == 0, 2.0, 0.0)) == 1
    assert stopped(np.append(again[:30], np.full(30, np.nan))) == 0


@pytest.mark.parametrize("late", [0, 2])
def test_without_a_current_three_samples_and_the_lag_are_left_out(late: int) -> None:
    """None where the capture begins with an open bridge."""
    volts = Channel(VOLTAGE, "V", np.zeros(100), delay_s=1e-4 * late)
    run = capture(
        100 * np.arange(100), COAST, drive(0.5), COAST, starts=(0, 2000, 5000),
        terminal_voltage=volts,
    )  # fmt: skip
    assert VOLTAGE in run.channels
    shows = np.flatnonzero(emf_shows(run, lay(run), run.channels[VOLTAGE])).tolist()
    assert shows == [*range(21), *range(51 + SAMPLES + late, 100)]
