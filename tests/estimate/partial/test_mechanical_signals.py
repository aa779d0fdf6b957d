"""What drove a motor and how it turned, read from a capture: averages, delays, gaps, signs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.capture.model import CURRENT, HELD, POSITION, SPEED, TORQUE, Capture, Channel, Wiring
from motorid.errors import DataError
from motorid.estimate.partial import mechanical_signals
from motorid.estimate.partial.mechanical_signals import (
    COASTING,
    COMMAND,
    Motion,
    drive_of,
    fresh,
    noise,
    of_capture,
    stands_still,
)
from motorid.estimate.partial.modulating_functions import _shapes, build

Floats = NDArray[np.float64]
H = 1e-3


def capture(n: int = 400, **channels: Channel | Floats) -> Capture:
    """Samples each millisecond; bare arrays are a current in A, a speed in rad/s, an angle."""
    units = {CURRENT: "A", SPEED: "rad/s", POSITION: "rad", TORQUE: "N·m"}
    made = {
        name: c if isinstance(c, Channel) else Channel(name, units[name], c)
        for name, c in channels.items()
    }
    return Capture(np.arange(n) * 1000, 1e6, made)


def wave(n: int = 400, hz: float = 5.0) -> Floats:
    return np.asarray(20.0 * np.sin(2 * np.pi * hz * H * np.arange(n)))


def test_a_drive_is_the_best_that_was_measured() -> None:
    each = {name: Channel(name, "", np.zeros(2)) for name in (COMMAND, CURRENT, TORQUE)}
    assert drive_of(each) == TORQUE
    del each[TORQUE]
    assert drive_of(each) == CURRENT
    del each[CURRENT]
    assert drive_of(each) == COMMAND
    assert drive_of({}) is None


def test_a_measured_speed_turns_by_its_trapezoids() -> None:
    w = wave()
    motion = of_capture(capture(current=w, speed=w), CURRENT)
    assert motion.turned == pytest.approx((w[1:] + w[:-1]) / 2 * H)
    assert motion.speed(0.05) == pytest.approx(w)
    assert motion.middle_s == pytest.approx(H * (np.arange(399) + 0.5))
    assert motion.period_s == pytest.approx(H)
    assert motion.top_speed == pytest.approx(np.percentile(np.abs(w), 99))


def test_a_position_becomes_a_speed_over_a_short_span() -> None:
    angle: Floats = (
        1.5 * (H * np.arange(400.0)) ** 2
    )  # steadily faster: any symmetric span is exact
    motion = of_capture(capture(current=wave(), position=angle), CURRENT)
    assert motion.measured_speed is None
    assert motion.turned == pytest.approx(np.diff(angle))
    half_s = 0.08  # a quarter of it: 10 samples to each side
    speed = motion.speed(half_s)
    assert speed[10:-10] == pytest.approx(3.0 * H * np.arange(400)[10:-10])
    assert speed[0] == pytest.approx((angle[10] - angle[0]) / (10 * H))
    assert speed[-1] == pytest.approx((angle[-1] - angle[-11]) / (10 * H))
    assert motion.speed(1e-5)[5] == pytest.approx((angle[6] - angle[4]) / (2 * H))


def test_a_gear_turns_the_motor_faster_and_coarser() -> None:
    geared = replace(
        capture(current=wave(), speed=Channel(SPEED, "rad/s", wave(), resolution=0.02)),
        wiring=Wiring(gear_ratio=4.0),
    )
    motion = of_capture(geared, CURRENT)
    assert motion.speed(0.05) == pytest.approx(4.0 * wave())
    assert motion.speed_quantum == pytest.approx(0.08)
    assert of_capture(capture(current=wave(), position=wave()), CURRENT).speed_quantum == 0.0


def test_what_one_side_averages_the_other_side_averages_too() -> None:
    w, i = wave(), wave(hz=3.0)
    mean = Channel(SPEED, "rad/s", w, kind="mean", aperture_s=4e-3)
    motion = of_capture(capture(current=i, speed=mean), CURRENT)
    weights = np.array([0.5, 1.0, 1.0, 1.0, 0.5]) / 4.0  # trapezoids over the last 4 ms
    wanted = np.convolve(i, weights, "valid")
    assert motion.drive[4:] == pytest.approx(wanted)
    assert motion.drive[0] == pytest.approx(i[0])  # before the record it stays
    assert motion.drive[1] == pytest.approx((3 * i[0] + (i[0] + i[1]) / 2) / 4)
    assert motion.speed(0.05) == pytest.approx(w)
    assert motion.aperture_s == 4e-3
    read = Channel(CURRENT, "A", i, kind="mean", aperture_s=4e-3)
    other = of_capture(capture(current=read, speed=w), CURRENT)
    assert other.drive == pytest.approx(i)
    assert other.speed(0.05)[4:] == pytest.approx(np.convolve(w, weights, "valid"))


def test_a_motion_that_was_read_later_is_taken_earlier() -> None:
    w = wave()
    late = Channel(SPEED, "rad/s", w, delay_s=7e-3)
    current = Channel(CURRENT, "A", w, delay_s=2e-3)
    moved = of_capture(capture(current=current, speed=late), CURRENT).speed(0.05)
    assert moved[:-5] == pytest.approx(w[5:])
    assert moved[-5:] == pytest.approx(w[-1])  # after the record it stays


def test_readings_that_are_missing_or_saturated_are_left_out() -> None:
    w, i = wave(), wave()
    i[50] = np.nan
    top = Channel(CURRENT, "A", i, raw_max=19.9)
    motion = of_capture(capture(current=top, speed=w), CURRENT)
    kept = np.isfinite(i) & ~(i >= 19.9)
    assert motion.time_s == pytest.approx(H * np.flatnonzero(kept))
    assert motion.drive == pytest.approx(i[kept])
    with pytest.raises(DataError, match="holds 15 usable samples"):
        of_capture(capture(16, current=np.r_[np.nan, np.ones(15)], speed=wave(16)), CURRENT)
    assert of_capture(capture(16, current=np.ones(16), speed=wave(16)), CURRENT)


def test_a_pause_parts_what_lies_before_from_what_lies_after() -> None:
    w = wave()
    one = capture(current=w, speed=w)
    ticks = one.ticks.copy()
    ticks[200:] += 4100  # five periods and a little to the next
    ticks[300:] += 3900
    found = of_capture(replace(one, ticks=ticks), CURRENT)
    assert np.flatnonzero(found.broken).tolist() == [199]


def test_a_sensor_that_repeats_itself_is_read_where_it_is_new() -> None:
    slow = np.repeat(wave(100), 4)
    one = Channel(SPEED, "rad/s", np.r_[slow[2:], slow[-1], slow[-1]])
    kept = fresh(np.arange(400), one, {SPEED: 4})
    assert kept.tolist() == list(range(2, 400, 4))
    assert fresh(np.arange(400), one, {}).tolist() == list(range(400))
    assert fresh(np.arange(400), one, {SPEED: 1}).tolist() == list(range(400))
    held = replace(capture(current=wave(), speed=one), provenance={HELD: {SPEED: 4}})
    motion = of_capture(held, CURRENT)
    assert motion.time_s == pytest.approx(H * np.arange(2, 400, 4))


def test_a_linear_axis_is_driven_by_a_force() -> None:
    metres = Channel(SPEED, "m/s", wave())
    force, torque = Channel(TORQUE, "N", wave()), Channel(TORQUE, "N·m", wave())
    assert of_capture(capture(torque=force, speed=metres), TORQUE).linear
    assert not of_capture(capture(torque=torque, speed=wave()), TORQUE).linear
    for drive, motion in ((torque, metres), (force, Channel(SPEED, "rad/s", wave()))):
        with pytest.raises(DataError, match="map both linear or both not"):
            of_capture(capture(torque=drive, speed=motion), TORQUE)


def test_nothing_drives_a_coast() -> None:
    motion = of_capture(capture(speed=wave()), COASTING)
    assert not motion.drive.any()
    assert motion.drive_name == COASTING
    with pytest.raises(DataError, match="lacks speed and position"):
        of_capture(capture(current=wave()), CURRENT)


def test_a_motor_that_never_moves_stands_still() -> None:
    assert stands_still(capture(speed=np.full(400, 3.0)))
    assert not stands_still(capture(speed=np.r_[np.full(399, 3.0), 3.1]))
    assert stands_still(capture(position=np.zeros(400)))
    assert not stands_still(capture(current=wave()))


def made(w: Floats, quantum: float = 0.0, broken: int | None = None) -> Motion:
    n = len(w)
    gaps = np.zeros(n - 1, dtype=bool)
    if broken is not None:
        gaps[broken] = True
    return Motion(
        H * np.arange(float(n)), np.zeros(n), (w[1:] + w[:-1]) / 2 * H, w, gaps, CURRENT, "A",
        False, False, quantum, 0.0, 0.0, 0.0,
    )  # fmt: skip


def test_a_motor_surely_turns_above_a_hundredth_of_its_top_speed() -> None:
    ramp = np.linspace(0.0, 100.0, 401)
    (found,) = made(ramp).stretches(0.01)
    assert (found.stop, found.sign) == (401, 1)
    top = made(ramp).top_speed
    assert ramp[found.start] > 0.01 * top >= ramp[found.start - 1]
    (coarse,) = made(ramp, quantum=5.0).stretches(0.01)
    assert ramp[coarse.start] > 10.0 >= ramp[coarse.start - 1]
    rough = ramp + np.random.default_rng(0).normal(0.0, 3.0, 401)
    begins = min(s.start for s in made(rough).stretches(0.01))
    assert rough[begins] > 3.0 * noise(rough)


def test_a_stretch_ends_at_a_gap_and_is_not_short() -> None:
    flat = np.full(100, 5.0)
    assert [(s.start, s.stop) for s in made(flat, broken=39).stretches(0.01)] == [
        (0, 40),
        (40, 100),
    ]
    assert [(s.start, s.stop) for s in made(flat, broken=6).stretches(0.01)] == [(7, 100)]
    assert [(s.start, s.stop) for s in made(flat, broken=7).stretches(0.01)] == [(0, 8), (8, 100)]
    back = np.r_[np.full(50, 5.0), np.full(50, -5.0)]
    assert [s.sign for s in made(back).stretches(0.01)] == [1, -1]


def test_the_noise_of_the_inertia_is_that_of_the_bumps_slope() -> None:
    """Over bumps in pure noise: ∫ φ' n dt over (∫ φ² dt)½."""
    rng = np.random.default_rng(4)
    half = 0.05
    rough = made(rng.normal(0.0, 0.3, 4000))
    time = H * np.arange(-50, 51)
    phi = 0.5 * (1 + np.cos(np.pi * time / half))
    slope = -0.5 * np.pi / half * np.sin(np.pi * time / half)
    scale = np.sqrt(H * float(phi @ phi))
    wanted = 0.3 * H * np.sqrt(float(slope @ slope)) / scale
    assert rough.inertia_noise(half) == pytest.approx(wanted, rel=0.06)
    assert made(wave(), quantum=0.6).inertia_noise(half) == pytest.approx(
        0.6 / np.sqrt(12.0) * H * np.sqrt(float(slope @ slope)) / scale, rel=0.02
    )
    angle = replace(rough, measured_speed=None, turned=np.diff(rng.normal(0.0, 1e-3, 4000)))
    bend = -0.5 * (np.pi / half) ** 2 * np.cos(np.pi * time / half)
    wanted = 1e-3 * H * np.sqrt(float(bend @ bend)) / scale
    assert angle.inertia_noise(half) == pytest.approx(wanted, rel=0.06)
    counted = np.round(np.cumsum(angle.turned) * 0.01)  # of counts that hardly ever change
    counts = replace(angle, turned=np.diff(counted), angle_quantum=1.0)
    assert counts.inertia_noise(half) == pytest.approx(wanted * 1e3 / np.sqrt(12.0), rel=0.01)


def test_a_jump_anywhere_between_two_readings_spreads_the_rows() -> None:
    """A step at many places of an interval, seen by trapezoids, less its exact integral."""
    quiet, half = made(np.full(400, 5.0)), 0.05
    assert quiet.jumps_variance(half) == 0.0
    since = H * np.arange(400) - 200.5 * H  # from the middle of the interval, the bump's top
    phi = 0.5 * (1 + np.cos(np.pi * since / half)) * (abs(since) < half)
    off = []
    for x in H * np.linspace(-0.475, 0.475, 20):
        exact = 0.5 * (half - x) - 0.5 * half / np.pi * np.sin(np.pi * x / half)
        off.append(0.6 * (H * float(phi @ (since > x)) - exact))
    row = float(np.var(off)) / (0.75 * half)  # over ∫ φ² dt
    usual = row * 0.75 * half / (399 * H)  # φ² is 3/4 of that over all rows, T / h of them
    jumped = replace(quiet, drive=np.where(since > 0.0, 0.6, 0.0))
    assert jumped.jumps_variance(half) == pytest.approx(usual, rel=0.01)


# rows of the balance


def test_a_row_is_its_drives_mean_times_its_weight() -> None:
    steady = replace(made(np.full(400, 5.0)), drive=np.full(400, 0.7))
    rows = build([steady], 0.05)
    assert rows.drive / rows.weight == pytest.approx(0.7)
    # ∫ φ dt = h and ∫ φ² dt = 3 h/4 of a raised cosine
    bumps = round(399 * H / 0.05)
    half = 399 * H / bumps
    assert rows.weight == pytest.approx(half / np.sqrt(0.75 * half), rel=1e-2)
    assert len(rows) == bumps - 1
    assert rows.time_s == pytest.approx(half * np.arange(1, bumps))
    assert rows.matrix[:, 0] == pytest.approx(0.0, abs=1e-2)  # no acceleration
    assert rows.matrix[:, 1] == pytest.approx(5.0 * rows.weight, rel=1e-2)
    assert rows.matrix[:, 2] == pytest.approx(rows.weight)
    assert rows.matrix[:, 3] == pytest.approx(rows.weight)


def test_a_steady_acceleration_is_all_of_the_inertias_column() -> None:
    for way in (1.0, -1.0):
        rows = build([made(way * (5.0 + 40.0 * H * np.arange(400.0)))], 0.05)
        assert rows.matrix[:, 0] == pytest.approx(way * 40.0 * rows.weight, rel=2e-2)
        assert rows.matrix[:, 2] == pytest.approx(way * rows.weight)


def test_rows_know_their_stretch_and_their_capture() -> None:
    back = made(np.r_[np.full(300, 5.0), np.full(300, -5.0)])
    rows = build([back, made(np.full(300, 5.0))], 0.05)
    assert sorted(set(zip(rows.stretch.tolist(), rows.capture.tolist(), strict=True))) == [
        (0, 0), (1, 0), (2, 1),
    ]  # fmt: skip
    some = rows.only(rows.capture == 1)
    assert len(some) == int((rows.capture == 1).sum())
    assert set(some.stretch.tolist()) == {2}
    none = build([made(np.zeros(300))], 0.05)
    assert len(none) == 0
    assert none.matrix.shape == rows.matrix[:0].shape
    assert none.shapes.shape == rows.shapes[:0].shape


def test_further_frictions_are_in_units_of_a_speed() -> None:
    square, fan, stribeck = _shapes(np.array([-50.0, 1.0, 100.0]), 100.0)
    assert square == pytest.approx([-25.0, 0.01, 100.0])
    assert fan == pytest.approx([50.0, 1.0, 100.0])
    assert stribeck == pytest.approx(
        [-100.0 * np.exp(-10.0), 100.0 * np.exp(-0.2), 100.0 * np.exp(-20.0)]
    )


def test_a_mean_over_an_aperture_is_that_of_the_straight_lines() -> None:
    """Before the first reading the signal is taken to have been as it was there."""
    time = np.array([1.0, 1.1, 1.2, 1.4, 1.5, 1.6])
    values = np.array([2.0, 3.0, 1.0, 5.0, 4.0, 4.0])
    found = mechanical_signals._averaged(time, values, 0.25)
    fine = np.linspace(0.7, 1.6, 90_001)
    shown = np.interp(fine, time, values)
    for at, mean in zip(time, found, strict=True):
        inside = (fine >= at - 0.25) & (fine <= at)
        expected = np.trapezoid(shown[inside], fine[inside]) / 0.25
        assert mean == pytest.approx(expected, rel=1e-3)
    assert mechanical_signals._averaged(time, values, 0.0) is values
