"""Where an open bridge begins to be one: each limit from both sides, on readings written down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import POSITION, Capture, Channel
from motorid.estimate.signals import opened_bridge as module
from motorid.estimate.signals.opened_bridge import Motor, Opening, _Signals, openings
from tests.estimate.signals.test_opened_bridge_signals import (
    BAND,
    COUNT,
    GONE,
    MOTOR,
    PEAK,
    log,
    signals,
    stepped,
)

Floats = NDArray[np.float64]
place = np.arange(COUNT)
EVERY_OTHER = (-1.0) ** place


# what the readings are


def test_a_band_is_a_millionth_of_the_highest_where_nothing_scatters() -> None:
    current = 3.0 * np.where(place < 200, 2.0 - np.exp(-place / 50.0), 0.0)
    found = _Signals.of(log(current, np.full(COUNT, 6.0)))
    assert found is not None
    assert found.band == pytest.approx(1e-6 * found.peak)
    assert found.peak == pytest.approx(5.94, abs=0.06)
    assert (found.speed, found.motor, found.blur) == (None, None, 0)


def test_a_band_is_one_and_a_half_quanta_of_readings_that_are_rounded() -> None:
    current, volts, speed = stepped(noise=0.0)
    found = _Signals.of(log(0.04 * np.round(current / 0.04), volts, speed))
    assert found is not None
    assert found.band == pytest.approx(0.06)
    assert module._quantum(np.tile([0.0, 0.3], 60), 0.0) == pytest.approx(0.3)


def test_a_position_that_is_hardly_read_shows_no_speed() -> None:
    position = Channel(POSITION, "rad", np.full(100, np.nan))
    assert module._speed(Capture(np.arange(100), 1000.0, {POSITION: position})) is None


# what the motor draws


def driven(count: int = COUNT, off: float = 0.0, level: float = 1.0, **other: object) -> _Signals:
    """So many samples with a current of some ``level``, none elsewhere; ``off`` by turns."""
    volts, speed = (
        level * (6.0 + np.sin(place / 9.0)),
        level * (100.0 + 20.0 * np.cos(place / 23.0)),
    )
    current = MOTOR.by_volts * volts - MOTOR.by_speed * speed + off * EVERY_OTHER
    current = np.where(place < count, current, 0.0)
    return signals(volts=volts, speed=speed, current=current, motor=None, **other)


@pytest.mark.parametrize(
    ("count", "level", "band", "told"),
    [
        (COUNT, 1.0, BAND, True),
        (32, 1.0, BAND, True),
        (31, 1.0, BAND, False),  # too few
        (COUNT, 0.14, BAND, False),  # of at most .27 A, where .3 A is nearly none
        (COUNT, 0.4, 0.2, False),  # of at most .77 A, where noise makes .8 A
        (COUNT, 0.8, BAND, True),
    ],
)
def test_a_motor_is_told_by_enough_samples_with_enough_current(
    count: int, level: float, band: float, told: bool
) -> None:
    found = module._motor(driven(count, level=level, band=band))
    assert (found is not None) is told
    if found is not None:
        assert found.by_volts == pytest.approx(MOTOR.by_volts, rel=0.05)
        assert found.by_speed == pytest.approx(MOTOR.by_speed, rel=0.05)


@pytest.mark.parametrize(("off", "told"), [(0.6, True), (0.75, False)])
def test_a_motor_explains_all_but_a_fifth_of_the_current(off: float, told: bool) -> None:
    """Of 3.4 A."""
    s = driven(off=off, level=3.0, peak=3.5)
    assert float(np.sqrt(np.mean(s.current**2))) == pytest.approx(3.4, rel=0.02)
    assert (module._motor(s) is not None) is told


def test_samples_far_from_the_motor_do_not_tell_it() -> None:
    s = driven(off=0.002)
    outliers = s.current + np.where(place % 10 == 3, 1.5, 0.0)
    found = module._motor(replace(s, current=outliers))
    assert found is not None
    assert found.by_volts == pytest.approx(MOTOR.by_volts, rel=0.01)
    assert found.by_speed == pytest.approx(MOTOR.by_speed, rel=0.01)
    assert found.offset_a == pytest.approx(0.0, abs=0.01)


def test_an_offset_is_as_unlikely_as_a_fifth_of_it_in_one_reading() -> None:
    """Least squares with one equation more, by the normal equations."""
    s = driven(40, off=0.05)
    few = np.flatnonzero(s.current != 0.0)
    shown = replace(s, current=np.where(place < 40, s.current + 0.3, 0.0))
    rise = np.gradient(shown.current)
    columns = np.column_stack([s.volts, -s.speed, rise, np.ones(COUNT)])[few]
    wanted = np.linalg.solve(
        columns.T @ columns + np.diag([0.0, 0.0, 0.0, 0.2**2]), columns.T @ shown.current[few]
    )
    found = module._motor(shown)
    assert found is not None
    assert (found.by_volts, found.by_speed, found.offset_a) == pytest.approx(
        (wanted[0], wanted[1], wanted[3]), rel=1e-6
    )
    assert 0.05 < found.offset_a < 0.29


# which stretches are one


@pytest.mark.parametrize(("apart", "alike"), [(0.4, True), (0.6, False), (1.5, False)])
def test_levels_within_half_a_band_are_one(apart: float, alike: bool) -> None:
    current = np.where(place < 230, 0.0, -apart * BAND)
    assert module._alike(signals(current=current), (200, 230), (230, 260)) is alike


@pytest.mark.parametrize(
    ("runs", "blur", "found"),
    [
        ([(50, 80)], 0, [(49, 80)]),
        ([(50, 80)], 2, [(47, 82)]),
        ([(1, 80)], 2, [(0, 82)]),
        ([(0, 80)], 0, [(0, 80)]),
        ([(300, 399)], 4, [(295, 400)]),  # the log ends
        ([(50, 80), (83, 90)], 0, [(49, 90)]),  # two samples after the end
        ([(50, 80), (84, 90)], 0, [(49, 80), (83, 90)]),
        ([(50, 80), (89, 95)], 2, [(47, 82), (86, 97)]),
        ([(50, 80), (87, 95)], 2, [(47, 97)]),
    ],
)
def test_an_opening_reaches_a_sample_and_a_blur_beyond_its_run(
    runs: list[tuple[int, int]],
    blur: int,
    found: list[tuple[int, int]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    s = signals(blur=blur)
    monkeypatch.setattr(_Signals, "of", classmethod(lambda _, capture: s))
    monkeypatch.setattr(module, "_idle", lambda _: iter([slice(*run) for run in runs]))
    monkeypatch.setattr(module, "_is_open", lambda _, run: True)
    monkeypatch.setattr(module, "_decayed_from", lambda _, start: start)
    for rest in (70, 1000):
        monkeypatch.setattr(module, "_rest", lambda _, run, rest=rest: rest)
        wanted = [Opening(a, b, min(rest, b)) for a, b in found]
        assert openings(log(s.current, s.volts)) == wanted


# what is open


@pytest.mark.parametrize(("many", "is_open"), [(3, False), (4, True)])
def test_four_samples_contradict_and_three_do_not(many: int, is_open: bool) -> None:
    volts = np.full(COUNT, 2.0)  # draws nothing at 50 rad/s
    volts[225 : 225 + many] = 6.0
    s = signals(volts=volts, speed=np.full(COUNT, 50.0), current=np.zeros(COUNT))
    assert module._is_open(s, GONE) is is_open


@pytest.mark.parametrize(("many", "is_open"), [(24, False), (30, True)])
def test_a_channel_lags_by_at_most_so_many_samples(many: int, is_open: bool) -> None:
    """Of a run of 200, a quarter of which is more."""
    volts = np.full(COUNT, 2.0)
    volts[100 : 100 + many] = 6.0
    s = signals(volts=volts, speed=np.full(COUNT, 50.0), current=np.zeros(COUNT))
    assert module._is_open(s, slice(100, 300)) is is_open


def braked(**other: object) -> _Signals:
    """6 V with 1 A, whose start with 2.4 A tells 2.5 ohm: 3.5 V are back-EMF."""
    current = np.where(GONE.start > place, 1.0, 0.0)
    current[:40] = 2.4
    return signals(current=current, motor=None, **other)


def test_a_speed_that_stays_is_no_open_bridge_whatever_the_motor_would_draw() -> None:
    assert module._is_open(braked(speed=None), GONE) is True
    assert module._is_open(braked(speed=np.full(COUNT, 100.0)), GONE) is False
    assert module._is_open(braked(), GONE) is True  # its speed falls


@pytest.mark.parametrize(
    ("volts", "amperes", "ohms"),
    [
        (0.12, 0.12, 1.0),
        (0.1, 0.1, 2.5),  # .11 A is the least that flows
        (0.0, 0.5, 2.5),  # nothing drives it
        (-0.5, 0.5, 2.5),
    ],
)
def test_the_resistance_is_at_most_what_a_driven_current_tells(
    volts: float, amperes: float, ohms: float
) -> None:
    """By the lowest of V/A among samples whose current flows with the voltage."""
    s = braked(speed=None)
    s.volts[40:60], s.current[40:60] = volts, amperes
    s.volts[GONE] = 0.5  # beside 6 V it is none
    assert module._should_brake(s, GONE) == pytest.approx((6.0 - ohms) / ohms)


def test_the_back_emf_is_that_of_the_samples_before_the_current_ends() -> None:
    s = braked(speed=None)
    s.volts[188:198], s.current[188:198] = 5.0, 0.5
    assert module._should_brake(s, GONE) == pytest.approx((5.0 - 2.5 * 0.5) / 2.5)


@pytest.mark.parametrize(("start", "volts"), [(5, 5.0), (3, 5.0), (2, 5.0)])
def test_at_the_beginning_of_a_log_they_are_fewer(start: int, volts: float) -> None:
    """Three of them, or the first alone."""
    s = braked(speed=None)
    s.current[:] = 0.0
    s.current[100:140], s.volts[100:140] = 2.4, 6.0
    s.volts[:start] = [5.0, 6.0, 3.0, 3.0, 3.0][:start]
    s.current[:start] = 1.0
    s.volts[start:65] = 0.0
    lowest = min(2.5, 3.0) if start == 5 else 2.5
    assert module._should_brake(s, slice(start, 65)) == pytest.approx((volts - lowest) / lowest)


def test_a_current_ends_at_once_from_the_third_sample_on() -> None:
    first = np.where(place < 1, 1.0, 0.0)
    assert module._ends_at_once(signals(current=first), 3) is True
    assert module._ends_at_once(signals(current=first), 2) is False
    last = np.where(place == 199, 1.0, 0.0)
    assert module._ends_at_once(signals(current=last), 200) is False  # its fall itself
    blurred = np.where((place == 193) | (place == 194), 1.0, 0.0)
    assert module._ends_at_once(signals(current=blurred, blur=2), 200) is True


@pytest.mark.parametrize(("slope", "slows"), [(0.046, False), (0.05, True)])
@pytest.mark.parametrize("measured", [True, False])
def test_a_fall_counts_from_four_deviations_of_its_means(
    slope: float, slows: bool, measured: bool
) -> None:
    """16 samples that are .1 off by turns, which a mean of four is not: second differences of .4,
    half of which is a deviation of .2; the mean of 4 is as good as 4/2 of them. 12 steps of the
    slope are to be more than 4 x .2 / sqrt(2) = .566.
    """
    shown = 9.0 - slope * place[:40] + 0.1 * EVERY_OTHER[:40]
    s = _Signals(shown, np.zeros(40), shown if measured else None, BAND, PEAK)
    assert bool(module._slows(s, slice(10, 26))) is slows


def test_a_voltage_that_begins_low_is_no_back_emf() -> None:
    volts = np.full(COUNT, 6.0)
    volts[GONE] = np.linspace(5.0, 3.0, 60)
    volts[GONE.start] = 1.1  # a fifth is 1.2 V
    assert module._slows(signals(speed=None, volts=volts), GONE) is False
    volts[GONE.start] = 1.3
    assert module._slows(signals(speed=None, volts=volts), GONE)


@pytest.mark.parametrize("offset", [0.0, 0.3, -0.3])
@pytest.mark.parametrize(("stop", "first"), [(200, 188), (5, 1)])
def test_a_current_that_halves_from_sample_to_sample_runs_out(
    stop: int, first: int, offset: float
) -> None:
    """For twelve samples at most, and not from the log's first."""
    current = np.where(place < stop, 0.02 * 2.0 ** np.minimum(stop - place, 30), 0.0) + offset
    assert module._decayed_from(signals(current=current), stop) == first


@pytest.mark.parametrize(
    ("last", "first"),
    [
        ((1.0, 0.4 * BAND), 200),  # less than half a band is no fall
        ((1.0, 0.6 * BAND), 198),
        ((1.0, 0.95, 0.3), 198),  # less than a twelfth is none either
        ((1.0, 0.9, 0.3), 197),
    ],
)
def test_a_current_falls_by_half_a_band_and_a_twelfth_at_least(
    last: tuple[float, ...], first: int
) -> None:
    current = np.where(place < 200, last[0], 0.0)
    current[200 - len(last) : 200] = last
    assert module._decayed_from(signals(current=current), 200) == first


def test_what_scatters_about_nothing_rests() -> None:
    """Readings that are a off by turns scatter by 4 a / sqrt(6) = 1.63 a. Of the voltage, .02 x 6
    and 4 x .0327 make .25 V; of the speed, .02 x 100 and 4 x .327 make 3.3 rad/s."""
    volts, speed = 6.0 + 0.02 * EVERY_OTHER, 100.0 + 0.2 * EVERY_OTHER

    def rest(low_v: float, slow: float) -> int:
        v = np.where((GONE.start <= place) & (GONE.stop > place), low_v + 0.02 * EVERY_OTHER, volts)
        w = np.where((GONE.start <= place) & (GONE.stop > place), slow + 0.2 * EVERY_OTHER, speed)
        return module._rest(signals(volts=v, speed=w), GONE)

    assert rest(0.0, 0.0) == rest(0.21, 2.9) == GONE.start
    assert rest(0.29, 0.0) == GONE.stop
    assert rest(0.0, 3.7) == GONE.stop


@pytest.mark.parametrize(("moves", "rests"), [(242, 244), (243, GONE.stop)])
def test_a_rest_is_of_sixteen_samples(moves: int, rests: int) -> None:
    volts = np.zeros(COUNT)
    volts[: GONE.start] = 6.0
    volts[moves] = 3.0
    assert module._rest(signals(volts=volts, speed=0.0 * volts), GONE) == rests


def test_a_motor_draws_by_voltage_and_speed() -> None:
    drawn = Motor(2.0, 0.1, 0.3).drawn(np.array([3.0]), np.array([7.0]))
    assert drawn == pytest.approx([2.0 * 3.0 - 0.1 * 7.0 + 0.3])
