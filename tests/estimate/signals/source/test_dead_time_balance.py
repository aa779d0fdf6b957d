"""The loss of a dead time between its six points, and the current that loses what it should."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from motorid.capture.model import Capture, Wiring
from motorid.estimate.signals.source.current_transient import PLACES, Rise
from motorid.estimate.signals.source.dead_time import (
    UNSURE,
    DeadTime,
    _within,
    dead_time_loss,
    swinging,
    turning,
)
from motorid.estimate.signals.time_grid import Part
from motorid.program import Decay, StepKind

Floats = NDArray[np.float64]
AMPERES = np.array([-1.0, -0.7, -0.5, 0.4, 0.6, 0.9])
VOLTS = np.array([-0.3, -0.1, 0.0, 0.0, 0.1, 0.4])
OHM = 0.8
RAIL, PWM_HZ, DEAD_S, COUNT = 6.0, 20e3, 1e-6, 40
PART = Part(4, COUNT, StepKind.DRIVE_DUTY, 0.5, Decay.SYNCHRONOUS_SLOW)


def dead(side: float = 1.0, blur: float = 0.0) -> DeadTime:
    starts, firsts = np.array([-1.0, 0.0, 0.1]), np.array([-0.5, 0.2, 0.4])
    return DeadTime(side, AMPERES, VOLTS, blur, starts, firsts)


def capture(**wiring: float) -> Capture:
    facts = {"pwm_hz": PWM_HZ, "dead_time_s": DEAD_S, "supply_voltage_v": RAIL, **wiring}
    return Capture(100 * np.arange(COUNT), 1e6, {}, wiring=Wiring(**facts))  # type: ignore[arg-type]


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("blur", [0.0, 0.02, 0.1])
def test_the_loss_is_its_mean_over_what_commutation_moves(side: float, blur: float) -> None:
    """By a sum over a normal distribution."""
    current = np.linspace(-1.3, 1.3, 53)
    at = np.linspace(-7.0, 7.0, 2801)
    weights = np.exp(-(at**2) / 2.0)
    along = side * current[:, None] + blur * at
    wanted = side * np.interp(along, AMPERES, VOLTS) @ weights / weights.sum()
    assert dead(side, blur).lost(current) == pytest.approx(wanted, abs=2e-5)


def solved(one: DeadTime, drop: float) -> float:
    """x + lost(x) / R = drop."""
    return float(brentq(lambda x: x + one.lost(np.array([x]))[0] / OHM - drop, -99.0, 99.0))


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("blur", "within"), [(0.0, 1e-9), (0.05, 1e-3)])
def test_the_current_that_is_balanced_loses_what_it_should(
    side: float, blur: float, within: float
) -> None:
    one = dead(side, blur)
    current = np.array([-9.0, -1.2, -0.4, 0.1, 0.55, 0.7, 1.0, 8.0])
    taken = np.array([0.2, -0.1, 0.0, 0.3, 0.0, 0.3, -0.4, 0.4])
    wanted = [solved(one, i + v / OHM) for i, v in zip(current, taken, strict=True)]
    assert one.balanced(current, taken, OHM) == pytest.approx(wanted, abs=within)
    assert one.balanced(current, one.lost(current), OHM) == pytest.approx(current, abs=within)


def test_where_readings_say_how_high_the_source_is_the_mean_stays() -> None:
    """What all of them lose more is the same, and none of the mean."""
    one = dead()
    current, taken = np.array([-0.2, 0.5, 0.62, 0.8, 1.5]), np.array([0.3, 0.3, 0.0, 0.1, 0.0])
    found = one.balanced(current, taken, OHM, by_readings=True)
    assert found.mean() == pytest.approx(current.mean(), abs=1e-9)
    higher = found + one.lost(found) / OHM - current - taken / OHM
    assert np.ptp(higher) < 1e-9
    assert abs(higher[0]) > 1e-3
    plain = one.balanced(current, taken, OHM)
    assert abs(plain.mean() - current.mean()) > 1e-3


@pytest.mark.parametrize(("resistance", "source"), [(OHM, 0.0), (0.5, 0.3)])
def test_a_current_swings_by_what_it_is_off_its_balance(resistance: float, source: float) -> None:
    one = DeadTime.of(capture(), PART, 1e-4, resistance)
    assert one is not None
    current = np.linspace(0.0, 1.2 * one.amperes[5], COUNT)
    taken = np.full(COUNT, 0.1)
    off = swinging(capture(), PART, current, taken, 1e-4, resistance, source)
    assert len(off) == COUNT - 4
    assert off[0] == 0.0  # in the first one R i is not all
    found = current[5:] - off[1:]
    assert found + one.lost(found) / OHM == pytest.approx(current[5:] + 0.1 / OHM, abs=1e-3)
    assert np.abs(off[1:]).min() > 1e-3
    two = swinging(capture(), replace(PART, stop=6), current, taken, 1e-4, resistance, source)
    assert two == pytest.approx(off[:2])


def test_nothing_swings_where_nothing_is_known_of_it() -> None:
    current, taken = np.ones(COUNT), np.full(COUNT, 0.2)
    still = np.zeros(COUNT - 4)
    assert swinging(capture(), PART, current, taken, 1e-4, 0.0).tolist() == still.tolist()
    none = capture(dead_time_s=0.0)
    assert swinging(none, PART, current, taken, 1e-4, OHM).tolist() == still.tolist()
    one = replace(PART, stop=5)
    assert swinging(capture(), one, current, taken, 1e-4, OHM).tolist() == [0.0]


def test_what_a_commutator_moves_is_a_share_of_the_back_emf() -> None:
    """At duty .5 of 6 V the motor turns with 3 V, of which .0015 are moved."""
    one = DeadTime.of(capture(), PART, 1e-4, OHM)
    assert one is not None
    assert one.blur == pytest.approx(0.0015 * 3.0 / OHM)
    fast = DeadTime.of(capture(), replace(PART, decay=Decay.FAST), 1e-4, OHM)
    assert fast is not None
    assert fast.blur == pytest.approx(0.0015 * 3.0 / OHM)
    bare = DeadTime.of(capture(), PART, 1e-4, 0.0)
    assert bare is not None
    assert bare.blur == 0.0


@pytest.mark.parametrize("level", [0.5, -0.5])
def test_a_first_period_without_a_current_lacks_its_dead_time(level: float) -> None:
    one = DeadTime.of(capture(), replace(PART, level=level), 1e-4, OHM)
    assert one is not None
    assert one.first(0.0) == pytest.approx(np.sign(level) * DEAD_S * PWM_HZ * RAIL)


@pytest.mark.parametrize(
    "facts", [{"dead_time_s": 0.0}, {"supply_voltage_v": 0.0}, {"dead_time_s": 26e-6}]
)
def test_a_dead_time_that_is_none_or_all_of_the_period_takes_nothing(facts: dict) -> None:
    assert DeadTime.of(capture(**facts), PART, 1e-4, OHM) is None


def test_between_two_points_a_loss_turns_with_the_current() -> None:
    """Straight there: (1.06 - 1/1.06) / (2 x .06) of its slope times the current."""
    long = capture(dead_time_s=5e-6)
    one = DeadTime.of(long, PART, 1e-4, 0.0)
    assert one is not None
    middle = float(one.amperes[4:].mean())
    slope = float(np.diff(one.volts[4:])[0] / np.diff(one.amperes[4:])[0])
    assert one.amperes[4] < middle / 1.06 < 1.06 * middle < one.amperes[5]
    found = turning(long, [Part(0, 4), PART], np.full(COUNT, middle), 1e-4, 0.0)
    relative = (1.0 + UNSURE - 1.0 / (1.0 + UNSURE)) / (2.0 * UNSURE)
    assert found[4:] == pytest.approx(slope * middle * relative)
    assert found[:4].tolist() == [0.0] * 4


def test_a_loss_is_that_without_a_resistance_unless_it_is_told() -> None:
    current = np.linspace(-0.5, 0.5, COUNT)
    plain, shown = dead_time_loss(capture(), [PART], current, 1e-4)
    bare, _ = dead_time_loss(capture(), [PART], current, 1e-4, 0.0)
    other, _ = dead_time_loss(capture(), [PART], current, 1e-4, 1.0)
    assert plain.tolist() == bare.tolist() == shown.tolist()
    assert np.abs(plain - other).max() > 1e-6


@pytest.mark.parametrize(
    ("level", "decay", "late"),
    [
        (0.4, Decay.SYNCHRONOUS_SLOW, 0.0),
        (0.4, Decay.FAST, 0.0),
        (-0.4, Decay.FAST, 0.3),  # forward comes first, for three tenths of the period
    ],
)
def test_each_period_of_a_rise_loses_by_the_current_that_it_begins_with(
    level: float, decay: Decay, late: float
) -> None:
    """Two periods an interval, of a current that rises in a line; the first has no ripple yet."""
    part = replace(PART, level=level, decay=decay)
    times = np.arange(2)[:, None] + PLACES
    rise = Rise(part, np.sign(level) * (0.3 + 0.25 * times), np.full(16, 1.0 / 16.0))
    one = dead(np.sign(level))
    found = _within(capture(), rise, one, 0.02)
    for row, place, begins in ((0, 15, 0.5), (1, 0, 1.0), (1, 7, 1.0), (1, 8, 1.5)):
        at = begins + late / 2.0
        # none is known before the first place of an interval
        at = max(at, np.floor(at) + PLACES[0])
        wanted = one.lost(np.array([np.sign(level) * (0.3 + 0.25 * at)]))[0]
        assert found[row, place] == pytest.approx(wanted)
    ahead = AMPERES[2] - AMPERES[3] if late else 0.0
    assert found[0, :8] == pytest.approx(one.first(0.02 + np.sign(level) * ahead))
    assert np.ptp(found[1]) > 0.0
