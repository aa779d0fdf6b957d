"""A small current that ends while the motor coasts tells that a bridge opened, whatever its end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.signals import opened_bridge as module
from motorid.estimate.signals.opened_bridge import QUICK, Opening, _Signals, openings
from tests.estimate.signals.test_opened_bridge_signals import (
    BAND,
    COUNT,
    GONE,
    MOTOR,
    PEAK,
    log,
    signals,
)

Floats = NDArray[np.float64]
SMALL_A = 0.15  # of which an end at once tells nothing: .2 A is the least
place = np.arange(COUNT)


def coasting(small: float = SMALL_A, level: float = MOTOR.offset_a, **other: object) -> _Signals:
    """6 V with a small current, then the back-EMF with none, while the speed falls by a third."""
    s = signals()
    assert s.speed is not None
    volts = np.where(place < GONE.start, 6.0, MOTOR.by_speed * s.speed / MOTOR.by_volts)
    current = np.where((GONE.start <= place) & (place < GONE.stop), level, small + level)
    return replace(s, volts=volts, current=current, **other)


def falling(fall: float) -> Floats:
    """The speed, which falls by so much as the current is gone."""
    speed = np.full(COUNT, 100.0)
    speed[GONE] = np.linspace(100.0, 100.0 - fall, 60)
    return speed


def test_a_small_current_that_ends_while_the_motor_coasts_was_let_go() -> None:
    s = coasting()
    assert not module._is_open(s, GONE)  # the terminals show what they would
    assert module._lets_go(s, GONE) is True
    assert s.speed is not None
    reversed_ = replace(s, volts=-s.volts, current=2.0 * MOTOR.offset_a - s.current, speed=-s.speed)
    assert module._lets_go(reversed_, GONE) is True
    for lacks in ({"motor": None}, {"speed": None}, {"blur": 2}):
        assert module._lets_go(coasting(**lacks), GONE) is False


@pytest.mark.parametrize(("small", "gone"), [(1.9, False), (2.1, True), (-2.1, False)])
def test_a_current_that_drove_the_motor_ends_from_two_bands(small: float, gone: bool) -> None:
    """One that braked it may end as its voltage rises: a closed bridge does that too."""
    assert module._lets_go(coasting(small * BAND), GONE) is gone


@pytest.mark.parametrize(
    ("peak", "level", "gone"),
    [
        (PEAK, 0.039, True), (PEAK, 0.041, False), (PEAK, -0.041, False),  # 2 % of 2 A
        (0.2, 0.009, True), (0.2, 0.011, False),  # a band
    ],
)  # fmt: skip
def test_none_flows_but_for_an_offset(peak: float, level: float, gone: bool) -> None:
    s = coasting(level=MOTOR.offset_a + level, peak=peak)
    assert module._lets_go(s, GONE) is gone


@pytest.mark.parametrize(("fall", "gone"), [(1.9, False), (2.1, True), (-30.0, False)])
def test_the_motor_gets_slower_by_a_fiftieth_of_its_highest_speed(fall: float, gone: bool) -> None:
    assert module._lets_go(coasting(speed=falling(fall)), GONE) is gone


def test_a_speed_that_scatters_as_much_does_not_show_it() -> None:
    noise = 8.0 * np.random.default_rng(5).standard_normal(COUNT)
    noise[GONE.start + QUICK], noise[GONE.stop - 1] = 5.0, -5.0
    assert module._lets_go(coasting(speed=falling(30.0) + noise), GONE) is True
    assert module._lets_go(coasting(speed=100.0 + noise), GONE) is False


@pytest.mark.parametrize(
    ("first", "last", "gone"), [(196, 198, True), (197, 198, False), (196, 197, False)]
)
def test_the_current_flowed_in_three_samples_before(first: int, last: int, gone: bool) -> None:
    """One that gets smaller from sample to sample passes zero, as that of a ramp does."""
    s = coasting()
    flows = (place >= first) & (place <= last)
    current = np.where(flows, SMALL_A, 0.0) + MOTOR.offset_a
    assert module._lets_go(replace(s, current=current), GONE) is gone


def test_a_log_that_begins_without_a_current_let_none_go() -> None:
    s = coasting()
    current = np.where(place < 2 * QUICK, SMALL_A, 0.0) + MOTOR.offset_a
    speed = np.linspace(100.0, 50.0, COUNT)
    volts = MOTOR.by_speed * speed / MOTOR.by_volts
    first = replace(s, current=current, speed=speed, volts=volts)
    assert module._lets_go(first, slice(2 * QUICK + 1, 60)) is True
    assert module._lets_go(first, slice(2 * QUICK, 60)) is False


@pytest.mark.parametrize(
    ("share", "gone"), [(0.0, False), (0.49, False), (0.51, True), (1.0, True)]
)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_terminals_fall_with_the_back_emf(share: float, gone: bool, way: float) -> None:
    """By a half of it at least. While diodes hold them, for two samples, they may be anywhere."""
    s = coasting(speed=falling(30.0))
    assert s.speed is not None
    emf = MOTOR.by_speed / MOTOR.by_volts * s.speed
    s.volts[GONE] = emf[GONE.start + QUICK] + share * (emf[GONE] - emf[GONE.start + QUICK])
    s.volts[GONE.start : GONE.start + QUICK] = -0.7
    current = way * (s.current - MOTOR.offset_a) + MOTOR.offset_a
    turned = replace(s, volts=way * s.volts, speed=way * s.speed, current=current)
    assert module._lets_go(turned, GONE) is gone


def test_only_the_end_of_the_current_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then the terminals show the back-EMF, which drives the model no more than the motor."""
    s = coasting(speed=falling(30.0))
    assert s.speed is not None
    s.speed[: GONE.start] = (6.0 * MOTOR.by_volts - SMALL_A) / MOTOR.by_speed
    monkeypatch.setattr(_Signals, "of", classmethod(lambda _, capture: s))
    found = openings(log(s.current, s.volts))
    assert found == [Opening(GONE.start - 2, GONE.start + QUICK, GONE.start + QUICK)]
