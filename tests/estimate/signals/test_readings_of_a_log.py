"""The voltage of a log between its readings, against integrals, exact low-passes and parabolas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

from motorid.capture.model import CURRENT, VOLTAGE, Capture, Channel, Phase
from motorid.estimate.signals.intersample_voltage import (
    BROKEN,
    JOINED,
    LOOSE,
    MEANS,
    MOST_JUMPS,
    RAMP,
    SOURCED,
    Shape,
    Waveform,
    of_log,
)
from motorid.estimate.signals.time_grid import Part, Timeline
from motorid.estimate.signals.voltage_jumps import scatter
from motorid.program import Decay, Program, Step, StepKind
from tests.estimate.signals.quieted import quiet

Floats = NDArray[np.float64]
RNG = np.random.default_rng(5)


def grid(count: int, period_s: float) -> Timeline:
    """Ticks at 0, period, …; tick n ends interval n."""
    return Timeline(period_s, count, np.arange(count), (Part(0, count),), 0.0)


def waveform(shape: Shape, volts: Floats, time_s: Floats | None = None) -> Waveform:
    stamps = np.arange(float(len(volts))) if time_s is None else time_s
    return Waveform(np.asarray(stamps), volts, shape, 1.0)


def steps(levels: tuple[float, ...] = (0.0, 5.0, -3.0, 2.0), each: int = 6) -> Floats:
    return np.repeat(levels, each).astype(float)


# means over the grid


@pytest.mark.slow
@given(st.lists(st.floats(-9.0, 9.0), min_size=8, max_size=24), st.floats(-1.5, 1.5))
def test_a_joined_voltage_is_averaged_as_its_straight_lines(
    volts: list[float], late: float
) -> None:
    v, time = np.array(volts), np.arange(len(volts)) * 1.0
    means = waveform(JOINED, v).means(grid(9, 0.5), late)
    fine = np.linspace(-0.5, 4.0, 4501) - late  # np.interp holds the ends, as the log does
    flux = np.concatenate([[0.0], np.cumsum(np.diff(fine) * _midpoints(np.interp(fine, time, v)))])
    wanted = np.diff(flux[::500]) / 0.5
    assert means == pytest.approx(wanted, abs=1e-3)


def _midpoints(values: Floats) -> Floats:
    return (values[1:] + values[:-1]) / 2


def test_a_curved_voltage_is_the_cubic_spline_through_its_readings() -> None:
    v = np.sin(np.arange(12.0))
    means = waveform("curved", v).means(grid(11, 1.0))
    spline = CubicSpline(np.arange(12.0), v)
    wanted = [quad(lambda t: float(spline(t)), n - 1.0, n)[0] for n in range(1, 11)]
    assert means[1:] == pytest.approx(wanted)
    assert means[0] == pytest.approx(v[0])  # before the log it stays


@pytest.mark.parametrize("shape", ["held", MEANS])
def test_a_level_stays_until_the_next(shape: Shape) -> None:
    v = steps()
    means = waveform(shape, v).means(grid(20, 1.0))
    assert means[1:] == pytest.approx(v[:19], abs=RAMP * np.ptp(v))


@pytest.mark.parametrize("shape", ["held", LOOSE, MEANS])
@pytest.mark.parametrize("late", [-1e-6, 0.0, 1e-6])
def test_a_jump_at_a_stamp_leaves_no_corner(shape: Shape, late: float) -> None:
    """By a lag a mean changes alike on either side; a jump of no duration would change one."""
    wave, line, step = waveform(shape, steps()), grid(20, 1.0), 1e-6
    before, now, after = (wave.means(line, late + k * step) for k in (-1, 0, 1))
    there = np.abs(after - before)
    assert there.max() > step
    assert np.abs(after - 2 * now + before).max() < 0.02 * there.max()


def test_ramps_take_nothing_from_the_whole() -> None:
    v = steps()
    held = waveform("held", v).means(grid(20, 1.0), -0.5)
    assert held == pytest.approx((np.concatenate([[v[0]], v])[:20] + v[:20]) / 2)


def test_after_the_last_reading_the_voltage_stays() -> None:
    v = np.array([1.0, 2.0, 4.0, 7.0])
    for shape in (JOINED, "held", "curved", BROKEN):
        means = waveform(shape, v).means(grid(9, 1.0))
        assert means[4:] == pytest.approx(7.0)


@pytest.mark.slow
@pytest.mark.parametrize("shape", [JOINED, "curved", "held"])
@given(late=st.floats(-2.0, 2.0))
def test_what_came_later_is_as_if_its_stamps_were_later(shape: Shape, late: float) -> None:
    v = np.cos(0.7 * np.arange(30.0))
    line = grid(20, 1.0)
    moved = waveform(shape, v, np.arange(30.0) + late).means(line)
    assert waveform(shape, v).means(line, late) == pytest.approx(moved, abs=1e-9)


# low-passes that the readings passed


@pytest.mark.parametrize("tau", [0.4, 1.7])
def test_held_levels_are_found_behind_a_low_pass(tau: float) -> None:
    """Each reading shows by how much the low-pass had followed the level until then."""
    v = steps()
    kept = np.exp(-1.0 / tau)
    shown = np.empty_like(v)
    shown[0] = v[0]
    for n in range(1, len(v)):
        shown[n] = kept * shown[n - 1] + (1 - kept) * v[n]
    means = waveform("held", shown).means(grid(len(v), 1.0), 0.0, (), tau)
    assert means[1:] == pytest.approx(v[:-1], abs=RAMP * np.ptp(v))
    declared = replace(waveform("held", shown), filter_s=tau)
    assert declared.means(grid(len(v), 1.0)) == pytest.approx(means)
    half = replace(waveform("held", shown), filter_s=tau / 2)
    assert half.means(grid(len(v), 1.0), 0.0, (), tau / 2) == pytest.approx(means)


@pytest.mark.parametrize("shape", [JOINED, "curved"])
def test_before_a_low_pass_a_slope_was_ahead_by_its_time_constant(shape: Shape) -> None:
    ramp = 0.3 * np.arange(40.0)
    means = waveform(shape, ramp).means(grid(30, 1.0), 0.0, (), 2.0)
    assert means[5:25] == pytest.approx(0.3 * (np.arange(5, 25) - 0.5) + 0.3 * 2.0)


def test_a_second_order_adds_the_bend() -> None:
    """v + a v' + b v'' of a parabola: 2 b more everywhere."""
    v = 0.05 * np.arange(40.0) ** 2
    line = grid(30, 1.0)
    first = waveform("curved", v).means(line, 0.0, (), 1.0)
    both = waveform("curved", v).means(line, 0.0, (), 1.0, 3.0)
    assert (both - first)[5:25] == pytest.approx(3.0 * 0.1)
    declared = replace(waveform("curved", v), filter_s=1.0, filter_s2=3.0).means(line)
    assert declared == pytest.approx(both)


# jumps


def test_a_broken_voltage_is_held_before_its_jumps_and_joined_elsewhere() -> None:
    v = np.concatenate([0.1 * np.arange(10), 6 + 0.1 * np.arange(10)])
    means = waveform(BROKEN, v).means(grid(19, 1.0))
    wanted = _midpoints(v)
    wanted[9] = v[9]
    assert means[1:] == pytest.approx(wanted[:18], abs=RAMP * np.ptp(v))


def test_a_jump_is_moved_by_its_share_of_the_time_before() -> None:
    v = steps((1.0, 5.0, 2.0))
    early = waveform("held", v, np.arange(18.0))._with_jumps(())
    assert np.array_equal(early.time_s, np.arange(18.0))
    loose = waveform(LOOSE, v)
    assert list(loose.jumps) == [6, 12]
    means = loose.means(grid(17, 1.0), 0.0, [0.25, 0.5])
    assert means[6] == pytest.approx(0.75 * 1.0 + 0.25 * 5.0)
    assert means[12] == pytest.approx(0.5 * 5.0 + 0.5 * 2.0)
    assert np.delete(means[1:], [5, 11]) == pytest.approx(np.delete(v[:16], [5, 11]))


@pytest.mark.parametrize("shape", [BROKEN, LOOSE, "held"])
def test_moved_jumps_are_those_of_a_log_with_such_stamps(shape: Shape) -> None:
    rng = np.random.default_rng(2)
    ramps = np.concatenate([np.linspace(0, 2, 100), np.linspace(5, 8, 100), np.full(100, 1.0)])
    v, time = ramps + 0.01 * rng.standard_normal(300), np.cumsum(rng.uniform(0.7, 1.3, 300))
    wave = waveform(shape, v, time)
    assert len(wave.jumps) == 2
    moved = time.copy()
    moved[wave.jumps] -= np.array([0.2, 0.6]) * (time[wave.jumps] - time[wave.jumps - 1])
    line = grid(280, 1.0)
    assert np.array_equal(
        wave.means(line, 0.3, [0.2, 0.6]), replace(wave, time_s=moved).means(line, 0.3)
    )


def test_where_one_stamp_is_irregular_its_jump_alone_is_unsure() -> None:
    v, time = steps(), np.arange(24.0)
    time[6:] += 0.3  # before the first jump
    assert list(waveform("held", v, time).jumps) == [6]
    assert list(waveform(JOINED, v, time).jumps) == []


def test_where_most_stamps_are_irregular_every_jump_is_unsure() -> None:
    v = steps()
    time = np.cumsum(np.where(np.arange(24) % 3 == 0, 1.0, 1.2))
    assert list(waveform("held", v, time).jumps) == [6, 12, 18]


def test_the_largest_jumps_are_unknowns_up_to_a_number() -> None:
    count = MOST_JUMPS + 20  # levels, with a jump less between them
    levels = np.tile([0.0, 6.0], count // 2)
    levels[1::2] += 0.1 * np.arange(count // 2)  # each pulse higher than the last
    found = waveform(LOOSE, np.repeat(levels, 4)).jumps
    assert len(found) == MOST_JUMPS
    assert list(found) == sorted(found)
    assert found[-1] == 4 * (count - 1)
    assert found[0] == 4 * 20 or found[0] == 4 * 19


def test_a_level_voltage_does_not_wander_and_one_behind_a_resistance_does() -> None:
    assert not waveform(BROKEN, steps()).wanders
    sagging = steps(each=60) + np.tile(np.exp(-np.arange(60) / 15), 4)
    assert waveform(BROKEN, sagging).wanders
    assert not waveform(BROKEN, np.zeros(24)).wanders


# noise


def test_the_scatter_of_readings_is_their_noise_whatever_the_voltage_does() -> None:
    smooth = 5 * np.sin(np.arange(4000) / 300.0)
    noise = 0.02 * RNG.standard_normal(4000)
    assert scatter(smooth + noise) == pytest.approx(0.02, rel=0.12)
    jumping = np.where(np.arange(4000) % 500 < 250, 6.0, -6.0)
    assert scatter(jumping + noise) == pytest.approx(0.02, rel=0.12)
    assert scatter(noise[:127]) == 0.0
    assert scatter(noise[:128]) > 0.0


def test_the_scatter_is_of_the_calm_stretches() -> None:
    noise = 0.02 * RNG.standard_normal(4000)
    noise[2000:] *= 50.0
    assert scatter(noise) == pytest.approx(0.02, rel=0.2)


def test_noise_about_a_parabola_is_taken_away_and_jumps_stay() -> None:
    place = np.arange(2000.0)
    smooth = 3.0 + 1e-3 * place + 1e-6 * (place - 900) ** 2
    smooth[1000:] += 4.0
    noisy = smooth + 0.05 * RNG.standard_normal(2000)
    left = quiet(noisy) - smooth
    away = np.abs(place - 1000) > 40
    inside = away & (place > 40) & (place < 1960)
    assert np.std(left[inside]) < 0.4 * 0.05
    assert np.abs(np.mean(left[inside])) < 0.005
    assert np.abs(left[~away]).max() < 0.3  # the jump of 4 V is as sharp as it was


def test_readings_without_noise_are_as_they_were() -> None:
    exact = np.repeat([0.0, 3.0, 5.0], 100)
    assert np.array_equal(quiet(exact), exact)


# of a capture


def log(volts: Floats, current: Floats | None = None, **facts: float | str | int) -> Capture:
    channels = {VOLTAGE: Channel(VOLTAGE, "V", volts, **facts)}  # type: ignore[arg-type]
    if current is not None:
        channels[CURRENT] = Channel(CURRENT, "A", current)
    return Capture(np.arange(len(volts)) * 1000, 1e6, channels)


def read(capture: Capture, shape: Shape = JOINED) -> Waveform:
    found = of_log(capture, capture.channels[VOLTAGE], shape)
    assert found is not None
    return found


def test_a_reading_is_of_the_time_before_its_delay_and_the_middle_of_its_window() -> None:
    v = steps()
    assert read(log(v)).time_s == pytest.approx(1e-3 * np.arange(24))
    assert read(log(v, delay_s=2e-4)).time_s[0] == pytest.approx(-2e-4)
    short = log(v, kind="mean", aperture_s=4e-4, delay_s=1e-4)
    assert read(short).time_s[0] == pytest.approx(-1e-4 - 2e-4)


def test_the_delay_of_a_filter_is_no_shift_of_the_stamps() -> None:
    """1/(1 + s t) delays a slope by t, which the model of the filter already does."""
    first = read(log(steps(), delay_s=5e-4, filter_s=3e-4))
    assert first.time_s[0] == pytest.approx(-2e-4)
    assert (first.filter_s, first.filter_s2) == pytest.approx((3e-4, 0.0))
    second = log(steps(), delay_s=5e-4, filter_s=2e-4, filter_order=2, filter_damping=0.7)
    found = read(second)
    assert (found.filter_s, found.filter_s2) == pytest.approx((2.8e-4, 4e-8))
    assert found.time_s[0] == pytest.approx(-2.2e-4)


def test_a_missing_reading_is_none() -> None:
    v = steps()
    v[3] = np.nan
    found = read(log(v))
    assert len(found.volts) == 23
    assert found.time_s[3] == pytest.approx(4e-3)


def test_a_capture_with_a_program_has_no_waveform_of_a_log() -> None:
    capture = log(steps())
    program = Program((Step(StepKind.DRIVE_VOLTS, 5.0, 1.0, Decay.DIODE),))
    run = replace(capture, program=program, phases=(Phase(0, 0),))
    assert of_log(run, run.channels[VOLTAGE], JOINED) is None
    missing = log(np.r_[1.0, np.full(10, np.nan)])
    assert of_log(missing, missing.channels[VOLTAGE], JOINED) is None


def test_means_are_levels_over_the_time_since_the_reading_before() -> None:
    v = steps((1.0, 2.0, 3.0))
    found = read(log(v), MEANS)
    assert found.shape == MEANS
    assert found.time_s == pytest.approx(1e-3 * (np.arange(18) - 1))
    assert found.volts == pytest.approx(v)
    assert found.window_s == 0.0
    declared = read(log(v, kind="mean", aperture_s=1e-3, delay_s=1e-4), JOINED)
    assert declared.shape == MEANS
    assert declared.window_s == pytest.approx(1e-3)
    assert declared.time_s == pytest.approx(1e-3 * (np.arange(18) - 1) - 1e-4)


@pytest.mark.parametrize(("window_s", "begun_s"), [(0.0, 4e-3), (0.8e-3, 4.2e-3)])
def test_after_a_missing_reading_a_mean_is_over_its_own_window(
    window_s: float, begun_s: float
) -> None:
    v = np.full(18, 2.0)
    v[4] = np.nan
    capture = log(v, kind="mean", aperture_s=window_s) if window_s else log(v)
    found = read(capture, MEANS)
    assert found.time_s[4] == pytest.approx(begun_s)
    assert found.time_s[3] == pytest.approx(2e-3)


def test_a_mean_says_when_the_voltage_jumped_in_its_time() -> None:
    v = steps((1.0, 5.0), each=10)
    v[10] = 0.25 * 1.0 + 0.75 * 5.0
    found = read(log(v), MEANS)
    k = int(np.argmax(found.volts > 3.0))
    assert found.time_s[k] == pytest.approx(9e-3 + 0.25e-3)
    assert len(found.volts) == 21


def test_behind_a_resistance_the_source_is_what_the_current_leaves() -> None:
    rng = np.random.default_rng(2)
    source, ohms = steps((0.0, 6.0, 3.0, 6.0), each=40), 0.5
    current = np.tile(np.exp(-np.arange(40) / 8.0), 4) * np.sign(source)
    volts = source - ohms * current + 1e-4 * rng.standard_normal(len(source))
    found = read(log(volts, current), SOURCED)
    assert found.ohms == pytest.approx(ohms, rel=0.01)
    assert found.volts == pytest.approx(source, abs=0.02)
    assert read(log(volts, current), BROKEN).ohms == 0.0
    assert read(log(volts), SOURCED).ohms == 0.0
