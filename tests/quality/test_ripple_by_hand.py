"""Harmonics, torque over a turn, scatter and steady stretches of signals made for them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from motorid.estimate.results.estimate import Curve
from motorid.quality import ripple
from motorid.quality.ripple import (
    LEAST_SAMPLES,
    Window,
    brush_noise,
    harmonics,
    relative_ripple,
    segment_ripple,
    turn_torque,
    windows,
)
from tests.quality.made_estimate import curve, estimate

ANGLE = np.linspace(0.0, 20 * np.pi, 2000, endpoint=False)


def window(
    current: np.ndarray, position: np.ndarray | None = None, level: float = 5.0,
    speed: float = 100.0, angle: np.ndarray = ANGLE,
) -> Window:  # fmt: skip
    left = np.zeros(len(current)) if position is None else position
    return Window(angle, np.asarray(current), left, level, 0.5, speed)


def test_harmonics_are_complex_amplitudes_beside_a_cubic() -> None:
    """a cos + b sin is the real part of (a - ib) e^(ik angle)."""
    drift = np.linspace(-1.0, 1.0, 2000)
    current = 3.0 + 2.0 * drift - drift**2 + 0.5 * drift**3
    current = current + 0.3 * np.cos(2 * ANGLE) + 0.4 * np.sin(2 * ANGLE) - 0.1 * np.sin(ANGLE)
    found = harmonics(window(current, 0.2 * np.cos(ANGLE) - drift**3), (1, 2))
    assert found.current[2] == pytest.approx(0.3 - 0.4j)
    assert found.current[1] == pytest.approx(0.1j)
    assert found.position[1] == pytest.approx(0.2)
    assert found.position[2] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(found.rest).max() < 1e-9
    assert max(found.current_sd, found.position_sd) < 1e-9


def test_the_deviation_of_an_amplitude() -> None:
    """√(2/n) of the noise: of a real part; the residual's degrees are n less six."""
    rng = np.random.default_rng(3)
    noise = rng.standard_normal(2000)
    found = harmonics(window(0.05 * noise, 0.7 * noise), (3,))
    freedom = 2000 - 6
    own = math.sqrt(float(found.rest @ found.rest) / freedom * 2.0 / 2000)
    assert found.current_sd == pytest.approx(own)
    assert found.current_sd == pytest.approx(0.05 * math.sqrt(2.0 / 2000), rel=0.1)
    assert found.position_sd == pytest.approx(14.0 * found.current_sd)
    short = harmonics(window(noise[:7], angle=np.linspace(0.0, 5.0, 7)), (1, 2))
    assert math.isfinite(short.current_sd)


def test_relative_ripple_is_the_mean_of_the_windows() -> None:
    """0.1 A at twice and 0.3 A at thrice a turn, at 2 ohm over 5 V and over -10 V."""
    one = window(0.1 * np.cos(2 * ANGLE) + 0.3 * np.sin(3 * ANGLE) + 2.0 * np.cos(7 * ANGLE))
    rng = np.random.default_rng(4)
    two = window(0.2 * np.cos(2 * ANGLE + 1.0) + 0.01 * rng.standard_normal(2000), level=-10.0)
    orders = (2, 3, 7)
    found = relative_ripple([one, two], 2.0, orders, (2, 3))
    sd = harmonics(two, orders).current_sd * 2.0 / 10.0 / 2.0
    assert found[0] == pytest.approx(0.3 * 2.0 / 5.0 / 2.0, abs=4 * sd)
    assert (found[1], found[2]) == (pytest.approx(sd), 3)
    value, _, order = relative_ripple([one, two], 2.0, orders, (2,))
    assert (value, order) == (pytest.approx((0.1 * 0.4 + 0.2 * 0.2) / 2.0, abs=4 * sd), 2)
    assert relative_ripple([one], 2.0, orders, orders)[2] == 7


def test_the_noise_of_a_segment() -> None:
    """Four bars, of which one departs by 0.2 A: the spread of all over the root of its readings."""
    place = np.floor(ANGLE * 4 / (2 * np.pi)).astype(int) % 4
    value, noise, worst = segment_ripple([window(0.2 * (place == 1))], 2.0, 4)
    own = 0.4 / 5.0 * ((place == 1) - 0.25) * 0.5 / 0.5 * 1.0
    assert (value, worst) == (pytest.approx(0.2 * 2.0 / 5.0), 1)
    assert noise == pytest.approx(math.sqrt(float((own**2).mean()) / 500), rel=1e-6)
    less, _, bad = segment_ripple([window(-0.2 * (place == 3))], 2.0, 4)
    assert (less, bad) == (pytest.approx(0.08), 3)
    few = window(0.2 * (place[:400] == 0), angle=ANGLE[:400])  # two turns, and no more
    assert segment_ripple([few], 2.0, 4)[2] == 0


def test_torque_of_current_and_of_motion() -> None:
    """K I + J (k w)² Θ: 0.01 · 0.2 at once a turn against 1e-6 · (2 · 100)² · 0.03 at twice."""
    one = window(0.2 * np.cos(ANGLE), 0.03 * np.cos(2 * ANGLE))
    found = turn_torque([one], 0.01, 1e-6)
    wave = 2e-3 * np.cos(ANGLE) + 1.2e-3 * np.cos(2 * ANGLE)
    assert found.peak_to_peak == pytest.approx(float(np.ptp(wave)), rel=1e-3)
    assert found.unbalance == pytest.approx(2e-3, rel=1e-4)
    both = turn_torque([window(0.2 * np.cos(ANGLE), -0.2 * np.cos(ANGLE))], 0.01, 1e-6)
    assert both.unbalance == pytest.approx(0.0, abs=1e-9)  # the current only drives the motion


def test_deviations_of_torque_and_what_directions_share() -> None:
    """The widest window has the deviation; torques of opposite sign leave no unbalance."""
    rng = np.random.default_rng(5)
    noise, other = rng.standard_normal(2000), rng.standard_normal(2000)
    one = window(0.2 * np.cos(ANGLE) + 0.01 * noise, 1e-3 * other)
    two = window(-0.1 * np.cos(ANGLE) + 0.01 * noise, 1e-3 * noise, speed=-50.0)
    found = turn_torque([one, two], 0.01, 1e-6)
    sds = []
    for w in (one, two):
        h = harmonics(w, (1, 2, 3, 4))
        sds.append([math.hypot(0.01 * h.current_sd, 1e-6 * (k * w.speed) ** 2 * h.position_sd)
                    for k in (1, 2)])  # fmt: skip
    assert found.peak_to_peak_sd == pytest.approx(2.0 * math.hypot(*sds[0]))
    weights = [1.0 / of[0] ** 2 for of in sds]
    assert found.unbalance_sd == pytest.approx(1.0 / math.sqrt(sum(weights)))
    shared = abs(2e-3 * weights[0] - 1e-3 * weights[1]) / sum(weights)
    assert found.unbalance == pytest.approx(shared, abs=4 * found.unbalance_sd)
    assert turn_torque([two, one], 0.01, 1e-6).peak_to_peak_sd == found.peak_to_peak_sd


def test_scatter_leaves_out_steps_and_little_current() -> None:
    """Noise of 1 % where 1 A flows; what lies within five samples of a step, or below 0.2, not."""
    rng = np.random.default_rng(6)
    fitted = np.concatenate([np.ones(400), np.full(400, -0.5), np.full(400, 0.19)])
    measured = fitted * (1.0 + 0.01 * rng.standard_normal(1200))
    measured[395:405] += 0.5
    measured[900:] += 0.3 * rng.standard_normal(300)
    found, sd = brush_noise(curve("current", measured, fitted))
    used = 2 * 400 - 5 - 1 - 5 - 5 + 1
    assert found == pytest.approx(0.01 * math.sqrt(30 / 31), rel=0.1)
    assert sd == pytest.approx(found / math.sqrt(used), rel=0.01)
    flat, _ = brush_noise(curve("current", np.ones(200) + 0.3, np.ones(200)))
    assert flat < 0.11  # an offset is slow but at the ends


@pytest.mark.parametrize(("count", "enough"), [(LEAST_SAMPLES, True), (LEAST_SAMPLES - 1, False)])
def test_scatter_needs_samples(count: int, enough: bool) -> None:
    for whole in (np.ones(count), np.concatenate([np.ones(count), np.zeros(200)])):
        value, sd = brush_noise(curve("current", whole, whole))
        if len(whole) > count:  # what is near the step is lost
            assert math.isnan(value)
        else:
            assert math.isfinite(value) is math.isfinite(sd) is enough
    for short in (3, 20):
        assert math.isnan(brush_noise(curve("current", np.ones(short), np.ones(short)))[0])


# ---- steady stretches: 2 ohm, 0.01 N·m/A, 500 readings a second ----------------------------------


def run(parts: tuple[tuple[int, float, float], ...], offset: float = 0.0) -> tuple[Curve, Curve]:
    """Stretches of so many readings with a current and a speed; readings lie 7 mA beside.

    A current that flows is never twice the same: what is read most often is that of no drive.
    """
    amps = np.concatenate([i * (1.0 + np.linspace(-1e-5, 1e-5, n)) for n, i, _ in parts])
    speed = np.concatenate([np.full(n, w) for n, _, w in parts])
    angle = np.concatenate([[0.0], np.cumsum(speed[:-1])]) * 2e-3
    current = curve("current", amps + offset + 7e-3, amps + offset, step_s=2e-3)
    return current, curve("position", angle + 0.02, angle, step_s=2e-3)


def found_in(
    parts: tuple[tuple[int, float, float], ...], offset: float = 0.0
) -> tuple[Window, ...]:
    return windows(estimate(curves=run(parts, offset), inputs=({},)))


def test_a_steady_stretch_by_hand() -> None:
    (found,) = found_in(((50, 0.0, 0.0), (200, 0.5, 300.0), (50, 0.0, 300.0)))
    assert (found.level, found.mean_current) == pytest.approx((4.0, 0.5), rel=1e-4)
    assert found.speed == pytest.approx(300.0)
    assert found.current == pytest.approx(np.full(len(found.angle), 7e-3))
    assert found.position == pytest.approx(np.full(len(found.angle), 0.02))
    assert 190 <= len(found.angle) <= 196
    assert np.diff(found.angle) == pytest.approx(np.full(len(found.angle) - 1, 0.6))
    (off,) = found_in(((50, 0.0, 0.0), (200, 0.5, 300.0), (50, 0.0, 300.0)), offset=0.05)
    assert (off.level, off.mean_current) == pytest.approx((4.0, 0.5), rel=1e-4)


@pytest.mark.parametrize(
    ("readings", "speed", "steady"),
    [(75, 300.0, True), (68, 300.0, False), (200, 35.0, True), (200, 31.0, False),
     (200, -35.0, True)],
)  # fmt: skip
def test_a_stretch_is_of_two_turns_and_64_readings(
    readings: int, speed: float, steady: bool
) -> None:
    """200 readings less six, 2 ms apart, turn by 12.57 rad from 32.4 rad/s."""
    sign = math.copysign(0.5, speed)
    found = found_in(((50, 0.0, 0.0), (readings, sign, speed), (50, 0.0, speed)))
    assert (len(found) == 1) is steady


def test_levels_part_the_stretches() -> None:
    found = found_in(((50, 0.0, 0.0), (200, 0.5, 300.0), (200, -0.7, -400.0), (50, 0.0, 0.0)))
    assert [w.level for w in found] == pytest.approx([4.0, -5.4], rel=1e-4)
    assert [w.speed for w in found] == pytest.approx([300.0, -400.0], rel=0.02)
    one = found_in(((50, 0.0, 0.0), (200, 0.5, 300.0), (200, 0.55, 300.0), (50, 0.0, 0.0)))
    assert len(one) == 1  # 0.1 V of 4 V is no step of the program


def test_an_open_bridge_is_no_steady_stretch() -> None:
    """Though the voltage hardly falls: 0.05 A are 0.1 V of 3.1 V."""
    (found,) = found_in(((50, 0.0, 0.0), (200, 0.05, 300.0), (400, 0.0, 300.0)))
    assert found.mean_current == pytest.approx(0.05, rel=1e-4)
    assert 190 <= len(found.angle) <= 196


def test_stretches_need_both_channels_and_both_parameters() -> None:
    current, position = run(((50, 0.0, 0.0), (200, 0.5, 300.0), (50, 0.0, 0.0)))
    whole = estimate(curves=(current, position), inputs=({}, {}))
    assert len(windows(whole)) == 1
    for curves in ((current,), (position,), (current, replace(position, capture=1))):
        assert windows(replace(whole, curves=curves)) == ()
    for name in ("R", "K"):
        one = replace(whole.parameters[name], value=None)
        assert windows(replace(whole, parameters={**whole.parameters, name: one})) == ()
    second = replace(whole, curves=tuple(replace(c, capture=1) for c in (current, position)))
    assert len(windows(second)) == 1
    assert len(windows(replace(whole, curves=(*whole.curves, *second.curves)))) == 2


def test_the_current_of_an_open_bridge_is_what_is_read_most() -> None:
    """Five times alike at the least; else it is taken for none."""
    often = np.array([0.3] * 5 + [0.1] * 4 + list(np.linspace(1.0, 2.0, 30)))
    assert ripple._open_current(curve("current", often, often)) == pytest.approx(0.3)
    seldom = often[1:]
    assert ripple._open_current(curve("current", seldom, seldom)) == 0.0
