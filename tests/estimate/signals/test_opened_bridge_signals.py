"""What tells an open bridge, on readings that were written down."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, POSITION, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.signals import opened_bridge as module
from motorid.estimate.signals.opened_bridge import FEWEST, Motor, _Signals, openings

Floats = NDArray[np.float64]

COUNT = 400
PEAK, BAND = 2.0, 0.01  # A
MOTOR = Motor(by_volts=0.5, by_speed=0.02, offset_a=0.003)
GONE = slice(200, 260)


def signals(**other: Any) -> _Signals:
    """6 V at a speed that draws 1 A; none from 200 to 260, while the speed falls."""
    volts, speed = np.full(COUNT, 6.0), np.full(COUNT, 100.0)
    current = MOTOR.drawn(volts, speed) - MOTOR.offset_a
    current[GONE], volts[GONE] = 0.0, 0.0
    speed[GONE] = np.linspace(100.0, 70.0, 60)
    return replace(_Signals(volts, current, speed, BAND, PEAK, 0, MOTOR), **other)


def log(current: Floats, volts: Floats | None = None, speed: Floats | None = None) -> Capture:
    series = {CURRENT: current, VOLTAGE: volts, SPEED: speed}
    units = {CURRENT: "A", VOLTAGE: "V", SPEED: "rad/s"}
    given = {n: y for n, y in series.items() if y is not None}
    channels = {n: Channel(n, units[n], y) for n, y in given.items()}
    return Capture(np.arange(len(current)), 1000.0, channels)


def stepped(seed: int = 2, noise: float = 0.002) -> tuple[Floats, Floats, Floats]:
    """Current, voltage and speed of a motor that is driven at two levels, off in between."""
    at, rng = np.arange(900), np.random.default_rng(seed)
    volts = np.where(at < 400, 6.0, np.where(at < 600, 0.0, 3.0))
    speed = np.where(at < 400, 100.0 * (1.0 - np.exp(-at / 80.0)), 100.0)
    speed = np.where((at >= 400) & (at < 600), 100.0 * np.exp(-(at - 400) / 300.0), speed)
    speed[600:] = 50.0 - 10.0 * np.exp(-np.arange(300) / 60.0)
    current = MOTOR.drawn(volts, speed)
    current[400:600] = MOTOR.offset_a
    return current + noise * rng.standard_normal(900), volts, speed


def test_a_steady_motor_is_told_by_its_driven_samples() -> None:
    current, volts, speed = stepped()
    found = _Signals.of(log(current, volts, speed))
    assert found is not None
    assert found.motor is not None
    assert found.motor.by_volts == pytest.approx(MOTOR.by_volts, rel=2e-3)
    assert found.motor.by_speed == pytest.approx(MOTOR.by_speed, rel=2e-3)
    assert found.motor.offset_a == pytest.approx(MOTOR.offset_a, abs=5e-3)
    assert found.peak == pytest.approx(np.percentile(np.abs(current), 98))
    assert found.blur == 0


@pytest.mark.parametrize("wrong", ["volts", "speed", "both"])
def test_a_motor_of_the_wrong_sign_is_none(wrong: str) -> None:
    current, volts, speed = stepped()
    volts = -volts if wrong in ("volts", "both") else volts
    speed = -speed if wrong in ("speed", "both") else speed
    found = _Signals.of(log(current, volts, speed))
    assert found is not None
    assert found.motor is None


def test_a_current_that_voltage_and_speed_do_not_explain_tells_no_motor() -> None:
    current, volts, speed = stepped()
    other = current + 1.5 * np.sin(0.05 * np.arange(900)) * (np.abs(current) > 0.1)
    found = _Signals.of(log(other, volts, speed))
    assert found is not None
    assert found.motor is None


def test_an_opening_lies_where_the_current_is_gone() -> None:
    current, volts, speed = stepped()
    (found,) = openings(log(current, volts, speed))
    assert (found.start, found.stop) == (pytest.approx(399, abs=2), pytest.approx(600, abs=2))
    assert found.rests == found.stop  # it still turns
    without = [log(current, None, speed), log(np.full(900, np.nan), volts, speed)]
    assert [openings(one) for one in without] == [[], []]


def test_noise_is_averaged_before_a_current_is_taken_for_none() -> None:
    current, volts, speed = stepped(noise=0.09)
    quiet = _Signals.of(log(stepped()[0], volts, speed))
    loud = _Signals.of(log(current, volts, speed))
    assert quiet is not None
    assert loud is not None
    assert (quiet.blur, loud.blur) == (0, 2)
    assert loud.band == pytest.approx(4.0 * 0.09 / np.sqrt(5.0), rel=0.15)
    (found,) = openings(log(current, volts, speed))
    assert (found.start, found.stop) == (pytest.approx(398, abs=4), pytest.approx(601, abs=4))
    assert _Signals.of(log(np.random.default_rng(1).standard_normal(900), volts, speed)) is None


@pytest.mark.parametrize("blur", [1, 2, 4])
def test_an_average_is_of_so_many_on_either_side(blur: int) -> None:
    values = np.random.default_rng(4).standard_normal(50)
    found = module._averaged(values, blur)
    assert len(found) == 50
    for k in range(blur, 50 - blur):
        assert found[k] == pytest.approx(values[k - blur : k + blur + 1].mean())
    first = np.concatenate([np.full(blur, values[0]), values[: blur + 1]])
    assert found[0] == pytest.approx(first.mean())
    assert module._averaged(values, 0) is values


@pytest.mark.parametrize(("known", "given"), [(63, False), (64, True)])
def test_missing_readings_come_from_their_neighbours(known: int, given: bool) -> None:
    values = np.arange(200.0)
    values[known:] = np.nan
    values[3] = np.nan if given else 3.0
    whole = module._whole(np.append(values, 500.0) if given else values)
    assert (whole is not None) is given
    if whole is not None:
        assert whole[3] == 3.0
        assert whole[200] == 500.0


def test_a_quantum_is_the_least_step_or_the_one_declared() -> None:
    few = np.tile([0.0, 0.3, 0.5, 1.0], 30)
    assert module._quantum(few, 0.0) == pytest.approx(0.2)
    assert module._quantum(few, 0.25) == 0.25
    assert module._quantum(np.ones(30), 0.1) == 0.1
    many = np.random.default_rng(1).standard_normal(100)
    assert module._quantum(many, 0.0) == 0.0
    edge = np.repeat(np.arange(25.0), 4)  # as many values as a quarter of the readings
    assert module._quantum(edge, 0.0) == 1.0
    assert module._quantum(np.append(np.repeat(np.arange(25.0), 4)[:-1], 30.0), 0.0) == 0.0


def test_a_position_shows_the_speed_by_its_slope() -> None:
    position = Channel(POSITION, "rad", 3.0 * 1e-3 * np.arange(100))
    capture = Capture(np.arange(100), 1000.0, {POSITION: position})
    assert module._speed(capture) == pytest.approx(np.full(100, 3.0))
    read = Channel(SPEED, "rad/s", np.arange(100.0))
    both = Capture(np.arange(100), 1000.0, {SPEED: read})
    assert module._speed(both) == pytest.approx(np.arange(100.0))
    assert module._speed(Capture(np.arange(100), 1000.0, {})) is None


def test_an_encoder_of_few_counts_tells_a_smooth_speed() -> None:
    """40 counts a turn, from rest to .5 count a sample: neighbours tell it to 250 rad/s alone."""
    step, at = 2.0 * np.pi / 40.0, np.arange(2000)
    true = step * 1e3 * 0.5 * (1.0 - np.exp(-at / 300.0))  # rad/s, of a sample a millisecond
    angle = step * np.floor(np.cumsum(true) * 1e-3 / step)
    capture = Capture(at, 1000.0, {POSITION: Channel(POSITION, "rad", angle, resolution=step)})
    found = module._speed(capture)
    assert found is not None
    side = 21  # samples in which a fast motor takes ten counts
    off = found[side:-side] - true[side:-side]
    assert np.abs(off).max() < 1.1 * step / (2 * side * 1e-3)  # one count over them
    assert np.abs(np.gradient(angle, 1e-3) - true).max() > 10.0 * np.abs(off).max()


@pytest.mark.parametrize(
    ("counts", "side"),
    [(0.0, 1), (0.099, 1), (0.11, 2), (1.01, 11), (1.09, 11), (3.1, 31), (3.3, 32), (90.0, 32)],
)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_speed_is_that_over_twenty_counts_of_a_fast_motor(
    counts: float, side: int, way: float
) -> None:
    """``counts``: a step of the encoder in what it turns by in a sample; 32 samples at most."""
    at = np.arange(400)
    angle = way * 0.03 * np.maximum(at - 200.0, 0.0)
    found = module._turning(angle, 1e-3 * at, counts * 0.03)
    assert np.flatnonzero(np.abs(found) > 1e-9)[0] == 201 - side
    assert found[200 + side :] == pytest.approx(np.full(200 - side, way * 30.0))
    assert found[200] == pytest.approx(way * 15.0)


def test_a_speed_is_by_the_stamps_and_one_sided_at_the_ends() -> None:
    time_s = np.cumsum(np.where(np.arange(100) % 3 == 0, 3e-3, 1e-3))
    assert module._turning(7.0 * time_s, time_s, 0.05) == pytest.approx(np.full(100, 7.0))
    square = np.arange(100.0) ** 2  # a fast one turns by 163 a sample: ten steps in 5.8
    found = module._turning(square, np.arange(100.0), 95.0)
    assert found[0] == pytest.approx(6.0)
    assert found[50] == pytest.approx(100.0)
    assert found[99] == pytest.approx((99.0**2 - 93.0**2) / 6.0)
    assert module._turning(np.ones(100), time_s, 0.05).tolist() == [0.0] * 100


def test_a_stretch_at_one_level_near_zero_is_idle() -> None:
    s = signals()
    assert list(module._idle(s)) == [GONE]
    short = s.current.copy()
    short[GONE], short[220 : 220 + FEWEST - 1] = 1.0, 0.0
    assert list(module._idle(signals(current=short))) == []
    short[220 : 220 + FEWEST] = 0.0
    assert list(module._idle(signals(current=short))) == [slice(220, 220 + FEWEST)]


def test_one_outlier_is_no_current_and_two_runs_at_one_level_are_one() -> None:
    one = signals().current.copy()
    one[230] = 1.0
    assert list(module._idle(signals(current=one))) == [GONE]
    one[231] = 1.0
    assert list(module._idle(signals(current=one))) == [GONE]
    one[232] = 1.0
    assert list(module._idle(signals(current=one))) == [slice(200, 230), slice(233, 260)]


def test_runs_at_other_levels_stay_apart() -> None:
    two = signals().current.copy()
    two[230:] = np.where(np.arange(COUNT - 230) < 30, 3.4 * BAND, 1.0)
    assert list(module._idle(signals(current=two))) == [slice(200, 230), slice(230, 260)]


@pytest.mark.parametrize(("part", "idle"), [(0.14, True), (0.16, False)])
def test_what_is_near_zero_is_a_share_of_the_highest(part: float, idle: bool) -> None:
    level = np.where(signals().current == 0.0, part * PEAK, 1.0)
    assert bool(list(module._idle(signals(current=level)))) is idle


@pytest.mark.parametrize(("volts", "is_open"), [(3.0, True), (2.45, False), (1.2, True)])
def test_what_a_connected_motor_would_draw_contradicts_none(volts: float, is_open: bool) -> None:
    """At 3 V and 50 rad/s it would draw .5 A, at 2.45 V .23 A, of which .4 A is enough; at 1.2 V it
    would brake with .4 A."""
    shown = signals().volts.copy()
    shown[GONE] = volts
    speed = np.full(COUNT, 50.0)
    late = signals(volts=shown, speed=speed, current=np.where(shown == 6.0, 2.0, 0.0))
    motor = replace(MOTOR, offset_a=0.0)
    if volts == 1.2:
        motor = replace(motor, by_speed=0.021)
    assert module._is_open(replace(late, motor=motor), GONE) is is_open


def test_a_channel_that_lags_is_no_open_bridge() -> None:
    """A contradiction at the edges alone."""
    shown = np.full(COUNT, 2.0)  # draws nothing at 50 rad/s
    shown[GONE.start : GONE.start + 14] = 6.0
    shown[GONE.stop - 14 : GONE.stop] = 6.0
    s = signals(volts=shown, speed=np.full(COUNT, 50.0), current=np.zeros(COUNT))
    assert not module._is_open(s, GONE)
    shown[GONE.start : GONE.start + 19] = 6.0  # four beyond the quarter that may lag
    assert module._is_open(replace(s, volts=shown), GONE)


@pytest.mark.parametrize(("before", "at_once"), [(0.19, False), (0.21, True)])
def test_an_end_at_once_is_from_much_more(before: float, at_once: bool) -> None:
    current = np.zeros(COUNT)
    current[197] = before
    assert module._ends_at_once(signals(current=current), 200) is at_once
    current[:197] = 1.0
    current[197] = 0.0
    assert not module._ends_at_once(signals(current=current), 200)  # it took longer
    assert module._ends_at_once(signals(current=current), 199)
    assert not module._ends_at_once(signals(current=np.ones(COUNT)), 2)  # nothing before it


def test_a_blurred_end_is_looked_for_earlier() -> None:
    current = np.where(np.arange(COUNT) < 194, 1.0, 0.0)
    assert not module._ends_at_once(signals(current=current), 200)
    assert module._ends_at_once(signals(current=current, blur=2), 200)


def test_a_coasting_motor_gets_slower() -> None:
    rng = np.random.default_rng(5)
    noise = 0.5 * rng.standard_normal(COUNT)
    assert module._slows(signals(speed=signals().speed + noise), GONE)
    assert not module._slows(signals(speed=100.0 + noise), GONE)
    risen = signals()
    assert risen.speed is not None
    assert not module._slows(replace(risen, speed=risen.speed[::-1].copy()), slice(140, 200))
    backwards = replace(risen, speed=-risen.speed + noise)
    assert module._slows(backwards, GONE)


def test_without_a_motion_the_voltage_falls() -> None:
    volts = np.full(COUNT, 6.0)
    volts[GONE] = np.linspace(4.0, 2.0, 60)
    assert module._slows(signals(speed=None, volts=volts), GONE)
    volts[GONE] = np.linspace(1.1, 0.5, 60)  # it began too low to be a back-EMF
    assert not module._slows(signals(speed=None, volts=volts), GONE)


def test_a_motor_at_no_voltage_would_brake_with_its_back_emf() -> None:
    """6 V with 1 A; a start with 2.4 A tells 2.5 ohm, so that 3.5 V is back-EMF."""
    current = np.where(np.arange(COUNT) < GONE.start, 1.0, 0.0)
    current[:40] = 2.4
    s = signals(speed=None, motor=None, current=current)
    assert module._should_brake(s, GONE) == pytest.approx(3.5 / 2.5)
    reversed_ = replace(s, volts=-s.volts, current=-s.current)
    assert module._should_brake(reversed_, GONE) == pytest.approx(3.5 / 2.5)
    high = s.volts.copy()
    high[GONE] = 1.3  # more than a fifth of the highest: no zero
    assert module._should_brake(replace(s, volts=high), GONE) == 0.0
    assert module._should_brake(replace(s, current=-s.current), GONE) == 0.0


def test_a_current_runs_out_through_diodes() -> None:
    current = np.where(np.arange(COUNT) < 190, 1.0, 0.0)
    assert module._decayed_from(signals(current=current), 190) == 189
    slope = current.copy()
    slope[190:198] = np.linspace(0.9, 0.1, 8)
    assert module._decayed_from(signals(current=slope), 198) == 189
    assert module._decayed_from(signals(current=np.linspace(0.4, 0.0, COUNT)), 300) == 300
    steep = np.maximum(0.0, 0.5 * (200.0 - np.arange(COUNT)))
    assert module._decayed_from(signals(current=steep), 200) == 188  # no more than 12 samples


def test_a_rest_begins_where_voltage_and_speed_are_gone_for_good() -> None:
    s = signals()
    assert s.speed is not None
    speed, volts = s.speed.copy(), s.volts.copy()
    speed[230:260] = 0.0
    still = replace(s, speed=speed, volts=volts)
    assert module._rest(still, GONE) == 231
    assert module._rest(s, GONE) == GONE.stop
    volts[240] = 3.0
    assert module._rest(replace(still, volts=volts), GONE) == 242
    volts[243] = 3.0  # it leaves 15 samples, one too few
    assert module._rest(replace(still, volts=volts), GONE) == GONE.stop
    assert module._rest(replace(still, speed=None), GONE) == GONE.stop
    speed[:] = 0.0
    speed[300:] = 100.0
    assert module._rest(replace(s, speed=speed), GONE) == GONE.start


def test_a_rest_tells_the_offset_where_one_noisy_level_does_not() -> None:
    """Noise of a voltage with one level alone hides which share of the current goes with it."""
    at, rng = np.arange(900), np.random.default_rng(4)
    volts = np.where(at < 100, 0.0, 6.0) + 0.01 * rng.standard_normal(900)
    speed = np.where(at < 100, 0.0, 100.0 * (1.0 - np.exp(-(at - 100) / 80.0)))
    current = MOTOR.drawn(np.where(at < 100, 0.0, 6.0), speed)
    found = _Signals.of(log(current + 0.002 * rng.standard_normal(900), volts, speed))
    assert found is not None
    assert found.motor is not None
    assert found.motor.offset_a == pytest.approx(MOTOR.offset_a, abs=2e-3)
