"""How a rise begins and what it is worth: ripple that a command changes, places, readings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, Capture, Channel, Wiring
from motorid.estimate.signals.source.current_transient import (
    PLACES,
    Rise,
    moving,
    rises,
    swing_at_start,
)
from motorid.estimate.signals.source.step_transient import HEAD
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
COUNT, PWM_HZ, RAIL, PERIOD_S = 40, 20e3, 12.0, 1e-4
HENRY, OHM = 0.5e-3, 0.5  # ten intervals, and a current that hardly bends within a PWM period
SLOW = Decay.SYNCHRONOUS_SLOW


def capture(pwm_hz: float = PWM_HZ, **channels: Channel) -> Capture:
    wiring = Wiring(pwm_hz=pwm_hz, supply_voltage_v=RAIL)
    return Capture(100 * np.arange(COUNT), 1e6, channels, wiring=wiring)


def part(start: int, stop: int, level: float, decay: Decay = SLOW) -> Part:
    return Part(start, stop, StepKind.DRIVE_DUTY, level, decay)


def half(duty: float, volts: float = RAIL) -> float:
    """A of a straight ripple on either side of its mean."""
    return volts * duty * (1.0 - duty) / (2.0 * HENRY * PWM_HZ)


@pytest.mark.parametrize(
    ("one", "swing"),
    [
        (part(0, 9, 0.3), half(0.3)),
        (part(0, 9, -0.3), -half(0.3)),
        (part(0, 9, 0.4, Decay.FAST), half(0.7, 24.0)),
        (part(0, 9, -0.4, Decay.FAST), half(0.7, 24.0)),  # its period begins forward
        (replace(part(0, 9, 0.3), discontinuous=True), 0.0),
        (Part(0, 9, StepKind.COAST), 0.0),
    ],
)
def test_a_period_begins_below_its_mean(one: Part, swing: float) -> None:
    assert swing_at_start(capture(), one, HENRY, OHM) == pytest.approx(swing, rel=0.02)


def test_a_command_changes_the_ripple_and_not_the_current() -> None:
    """The mean jumps by what the beginning of a period lies lower, and forgets it."""
    mean = np.linspace(0.0, 4.0, COUNT)
    parts = [part(0, 10, 0.1), part(10, 15, 0.6), Part(15, COUNT, StepKind.COAST)]
    with_ripple = list(rises(capture(), parts, mean, mean + 0.05, HENRY, OHM))
    without = list(rises(capture(0.0), parts, mean, mean + 0.05, HENRY, OHM))
    assert [one.where for one in with_ripple] == [slice(10, 15), slice(15, 15 + HEAD)]
    more = with_ripple[0].amperes - without[0].amperes
    since = np.arange(5)[:, None] + PLACES
    jump = half(0.6) - half(0.1)
    assert more == pytest.approx(jump * np.exp(-since / 10.0), rel=0.02)
    assert with_ripple[1].amperes == pytest.approx(without[1].amperes)  # the bridge is open
    assert without[0].amperes.mean(axis=1) == pytest.approx(mean[10:15])


@pytest.mark.parametrize(
    ("henry", "ohm", "count"), [(HENRY, 0.5, 1), (0.0, 0.5, 0), (HENRY, 0.0, 0), (-1.0, 0.5, 0)]
)
def test_without_inductance_or_resistance_no_rise_is_known(
    henry: float, ohm: float, count: int
) -> None:
    mean = np.linspace(0.0, 4.0, COUNT)
    found = list(rises(capture(), [part(0, 10, 0.1), part(10, 40, 0.6)], mean, mean, henry, ohm))
    assert len(found) == count


def test_a_current_that_nobody_reads_has_places_of_equal_worth() -> None:
    mean = np.linspace(0.0, 4.0, COUNT)
    parts = [part(0, 10, 0.1), part(10, 40, 0.6)]
    (risen,) = rises(capture(), parts, mean, mean, HENRY, OHM)
    assert risen.weights == pytest.approx(np.full(16, 1.0 / 16.0))
    early = Channel(CURRENT, "A", mean, delay_s=PERIOD_S / 2)
    (risen,) = rises(capture(**{CURRENT: early}), parts, mean, mean, HENRY, OHM)
    assert not risen.weights[8:].any()  # it is of the middle of the interval
    assert risen.weights[:8] == pytest.approx(
        risen.weights[7] * np.exp((PLACES[:8] - PLACES[7]) / 10)
    )
    assert risen.weights.sum() == pytest.approx(1.0)


RISE = Rise(part(3, 20, 0.5), np.array([2.0, 7.0])[:, None] + 3.0 * PLACES, np.eye(16)[4])


def test_a_rise_at_other_places_is_joined_by_lines() -> None:
    found = RISE.at(np.array([0.1, 0.5, 0.9]))
    assert found == pytest.approx(np.array([[2.3, 3.5, 4.7], [7.3, 8.5, 9.7]]))


def test_a_mean_of_risen_intervals_is_what_a_reading_is_moved_by() -> None:
    mean = np.full(COUNT, 1.0)
    moved = moving(mean, [RISE])
    assert moved[3:5] == pytest.approx([2.0 + 3.0 * PLACES[4], 7.0 + 3.0 * PLACES[4]])
    assert np.delete(moved, [3, 4]).tolist() == [1.0] * (COUNT - 2)
    assert mean.tolist() == [1.0] * COUNT
