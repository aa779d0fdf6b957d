"""The compiled response against an adaptive integrator that shares nothing with it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import NAMES, WideResponse
from tests.motor_reference import Reference

FAULHABER = (2.6, 180e-6, 7.68e-3, 3e-7, 3.9e-7, 3e-4)
ALL_READINGS = (
    Output(Quantity.CURRENT),
    Output(Quantity.CURRENT, 0.5, 0.2),
    Output(Quantity.CURRENT, 7.3, 1.4),
    Output(Quantity.SPEED),
    Output(Quantity.SPEED, 1.0, 0.0),
    Output(Quantity.POSITION),
    Output(Quantity.POSITION, 0.0, 2.25),
)  # apertures and delays in sample periods; scaled in `readings`


def readings(period: float) -> list[Output]:
    return [Output(o.quantity, o.aperture_s * period, o.delay_s * period) for o in ALL_READINGS]


def largest_error(motor, period, v, stretches) -> float:
    """Over all readings, relative to each reading's own range."""
    outputs = readings(period)
    ours = Response(period, v, outputs, stretches)(motor)
    reference = Reference(motor, max_step=period)
    reference.run(period, v, stretches)
    errors = []
    for output, y in zip(outputs, ours, strict=True):
        z = reference.read(output, np.arange(len(v)) * period)
        errors.append(np.abs(y - z).max() / max(np.abs(z).max(), 1e-9))
    return max(errors)


decades = st.floats(-1, 1).map(lambda e: 10.0**e)


@st.composite
def cases(draw):
    """A random motor, scaled to its sample period, and a program that starts, stops and coasts."""
    R, K = 2.6 * draw(decades), 7.68e-3 * draw(decades)
    J, T0 = 3.9e-7 * draw(decades), 3e-4 * draw(decades)
    tau_m = J * R / K**2
    L = R * tau_m * draw(st.sampled_from([0.01, 0.1, 0.25, 0.3, 2.0]))
    B = J / tau_m * draw(st.sampled_from([0.0, 0.01, 0.5, 2.0]))
    period = tau_m * draw(st.sampled_from([0.02, 0.1, 0.5]))
    stall = R * T0 / K
    levels = [stall * draw(st.floats(-6, 6)) for _ in range(3)]
    v = np.concatenate([np.zeros(4), *[np.full(12, level) for level in levels], np.zeros(12)])
    clamp = draw(st.sampled_from([0.0, 8 * stall]))
    series = R * draw(st.sampled_from([0.0, 0.2]))
    opens = [True, False, False, draw(st.booleans()), True]
    starts = [0, 4, 16, 28, 40]
    stretches = [
        Stretch(start, opened, series, clamp) for start, opened in zip(starts, opens, strict=True)
    ]
    return (R, L, K, B, J, T0), period, v, stretches


@pytest.mark.slow
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(cases())
def test_response_agrees_with_an_adaptive_integrator(case) -> None:
    assert largest_error(*case) < 2e-8


@pytest.mark.slow
def test_start_run_coast_and_stop_of_a_real_motor() -> None:
    v = np.zeros(420)
    v[20:200] = 6.0
    v[200:300] = -1.0
    plan = [
        Stretch(0, True),
        Stretch(20, False, 0.1),
        Stretch(200, False, 0.1),
        Stretch(300, True, 0.1, 7.0),
    ]
    assert largest_error(FAULHABER, 1e-4, v, plan) < 2e-8


def test_friction_holds_the_motor_below_its_torque() -> None:
    R, _, K, _, _, T0 = FAULHABER
    v = np.full(50, 0.9 * R * T0 / K)
    current, position = Response(
        1e-4, v, [Output(Quantity.CURRENT), Output(Quantity.POSITION)]
    )(FAULHABER)  # fmt: skip
    assert current[-1] == pytest.approx(0.9 * T0 / K)
    assert not position.any()


def test_without_friction_is_the_limit_of_a_little() -> None:
    """No torque holds the motor before the first current: it must not start a sample late."""
    v = np.zeros(300)
    v[10:150] = 3.0
    response = Response(1e-4, v, readings(1e-4), [Stretch(0)])
    none, little = response((*FAULHABER[:5], 0.0)), response((*FAULHABER[:5], 1e-12))
    for a, b in zip(none, little, strict=True):
        assert np.abs(a - b).max() < 1e-6 * np.abs(a).max()


def test_without_inductance_is_the_limit_of_a_small_one() -> None:
    v = np.zeros(300)
    v[10:150] = 6.0
    plan = [Stretch(0, True), Stretch(10), Stretch(200, True, clamp_v=7.0)]
    R, _, K, B, J, T0 = FAULHABER
    response = Response(1e-4, v, readings(1e-4), plan)
    none, small = response((R, 0.0, K, B, J, T0)), response((R, 1e-9, K, B, J, T0))
    for a, b in zip(none, small, strict=True):
        assert np.abs(a - b).max() < 2e-5 * np.abs(a).max()


@pytest.mark.parametrize("name", range(6))
def test_response_is_smooth_in_every_parameter(name: int) -> None:
    """Halving a finite difference halves its error: no kink, no noise of the event search."""
    v = np.zeros(600)
    v[13:200] = 6.0
    v[200:300] = -3.0
    plan = [Stretch(0, True), Stretch(13), Stretch(300, True, clamp_v=7.0)]
    response = Response(1e-4, v, readings(1e-4), plan)

    def slope(step: float) -> np.ndarray:
        up, down = list(FAULHABER), list(FAULHABER)
        up[name] *= 1 + step
        down[name] *= 1 - step
        return (response(up) - response(down)) / (2 * step)

    coarse, fine = slope(1e-4), slope(1e-6)
    for a, b in zip(coarse, fine, strict=True):
        kinks = np.abs(a - b) > 1e-3 * np.abs(b).max() + 1e-9
        assert kinks.sum() <= 3  # the few intervals in which an event crosses a tick


@pytest.mark.parametrize("aperture", [0.0, 20e-6, 50e-6])
@pytest.mark.parametrize("phase", [0.0, 0.2, 0.4, 0.7])
def test_ripple_agrees_with_switching(phase: float, aperture: float) -> None:
    """Against the switched voltage itself, fed to the same equations at a fine step."""
    R, L, K, B, J, T0 = (2.6, 180e-6, 7.68e-3, 3e-7, 3.9e-6, 0.0)
    period, pwm, fine, supply = 1e-4, 5e-5, 200, 6.0
    duties = {1: 0.4, 21: 0.75, 41: 0.0}
    level = np.repeat([0.4, 0.75, 0.0], [20, 20, 20])
    delay = (1 - phase) * pwm
    reading = Output(Quantity.CURRENT, aperture, delay)
    on = np.tile(np.arange(fine), 2)[None, :] < level[:, None] * fine
    exact = Response(pwm / fine, np.append(0.0, on.ravel() * supply), [reading])(
        (R, L, K, B, J, T0)
    )[0]
    averaged = Response(
        period,
        np.append(0.0, level * supply),
        [reading],
        [Stretch(n, duty=d, swing_v=supply) for n, d in duties.items()],
        pwm,
    )((R, L, K, B, J, T0))[0]
    ripple = 0.4 * 0.6 * supply * pwm / L
    assert np.abs(averaged - exact[:: 2 * fine]).max() < 2e-3 * ripple


def chopped(motor, duties, supply, pwm, fine, reading):
    """A bridge of diodes at a fine step: volts (n,) over each PWM period, and the reading."""
    R, L, K = motor[:3]
    on = [round(duty * fine) for duty in duties]
    volts, stretches, tick = [0.0], [], 1
    for k in on:
        stretches += [Stretch(tick), Stretch(tick + k, open=True, clamp_v=supply + 1.4)]
        volts += [supply] * k + [0.0] * (fine - k)
        tick += fine
    outputs = [
        reading,
        Output(Quantity.CURRENT),
        Output(Quantity.CURRENT, pwm),
        Output(Quantity.SPEED, pwm),
    ]
    read, now, mean, speed = Response(pwm / fine, np.array(volts), outputs, stretches)(motor)
    ends = np.arange(0, tick, fine)
    level = R * mean[ends][1:] + K * speed[ends][1:] + L * np.diff(now[ends]) / pwm
    return np.append(0.0, level), read[ends]


@pytest.mark.parametrize("aperture", [0.0, 17e-6, 50e-6])
@pytest.mark.parametrize("phase", [0.0, 0.1, 0.3, 0.55, 0.9])
def test_a_current_that_stops_agrees_with_switching(phase: float, aperture: float) -> None:
    """Diode decay: 30 periods in which the current stops, then 30 in which it flows on."""
    motor = (2.6, 180e-6, 7.68e-3, 3e-7, 3.9e-6, 0.0)
    pwm, supply = 5e-5, 6.0
    reading = Output(Quantity.CURRENT, aperture, (1 - phase) * pwm)
    duties = np.repeat([0.3, 0.8], 30)
    volts, exact = chopped(motor, duties, supply, pwm, 100, reading)
    clamp, swing = supply + 1.4, 2 * supply + 1.4
    plan = [
        Stretch(1, clamp_v=clamp, duty=0.3, swing_v=swing, discontinuous=True),
        Stretch(31, clamp_v=clamp, duty=0.8, swing_v=swing),
    ]
    averaged = Response(pwm, volts, [reading], plan, pwm)(motor)[0]
    peak = 0.3 * supply * pwm / motor[1]
    assert np.abs(averaged - exact)[2:].max() < 5e-3 * peak
    backwards = [
        Stretch(s.start, clamp_v=clamp, duty=s.duty, swing_v=-swing, discontinuous=s.discontinuous)
        for s in plan
    ]
    mirrored = Response(pwm, -volts, [reading], backwards, pwm)(motor)[0]
    np.testing.assert_allclose(mirrored, -averaged, atol=1e-12)


def test_a_rotor_that_stands_is_a_winding_and_no_more() -> None:
    R, L, K, *_, T0 = FAULHABER
    h, volts = 2e-5, np.r_[0.0, np.full(199, 2.0)]
    outputs = [Output(Quantity.CURRENT), Output(Quantity.SPEED)]
    plan = [Stretch(1, still=True), Stretch(100)]
    current, speed = Response(h, volts, outputs, plan)(FAULHABER)
    rise = 2.0 / R * (1 - np.exp(-R / L * h * np.arange(100)))
    assert K * rise[-1] > 5 * T0  # it would have moved
    np.testing.assert_allclose(current[:100], rise, rtol=1e-9)
    assert not speed[:100].any()
    assert speed[101] > 0.0
    late = Response(h, volts[:101], outputs)(FAULHABER, (rise[-1], 0.0, 0.0))
    np.testing.assert_allclose([current[100:], speed[100:]], late[:, 1:101], rtol=1e-9)


def test_initial_state_is_held_before_the_record() -> None:
    y = Response(1e-3, np.zeros(5), [Output(Quantity.POSITION, 0.0, 2e-3)], [Stretch(0, True)])(
        (1.0, 0.0, 0.01, 0.0, 1e-5, 0.0), (0.0, 3.0, 1.0)
    )
    np.testing.assert_allclose(y[0], 1.0 + 3.0 * (np.arange(5) - 2) * 1e-3, rtol=1e-12)


def test_refuses_a_motor_that_cannot_be() -> None:
    response = Response(1e-3, np.zeros(5), [Output(Quantity.CURRENT)])
    with pytest.raises(ValueError, match="no response"):
        response((-1.0, 0.0, 0.01, 0.0, 1e-5, 0.0))


# A fixed case that once mattered: exactly repeated eigenvalues.
REPEATED = (1.0, 1e-3, 0.05, 0.0, 1e-5, 1e-3)


@pytest.mark.slow
@example(4 * 0.05**2 * 1e-3 / 1.0)
@given(st.floats(1e-6, 1e-3))
@settings(max_examples=3, deadline=None)
def test_repeated_and_complex_eigenvalues(inertia: float) -> None:
    R, L, K, B, _, T0 = REPEATED
    v = np.zeros(60)
    v[4:40] = 5.0
    plan = [Stretch(0, True), Stretch(4), Stretch(45, True, clamp_v=6.0)]
    assert largest_error((R, L, K, B, inertia, T0), 5e-4, v, plan) < 2e-8


def test_a_kick_changes_the_speed_of_a_turning_motor_and_never_its_direction() -> None:
    volts, h = np.full(400, 6.0), 1e-4
    motor = (2.6, 180e-6, 7.68e-3, 3e-7, 3.9e-7, 3e-4)
    output = [Output(Quantity.SPEED)]

    def speed(kick: float) -> np.ndarray:
        response = Response(h, volts, output, [Stretch(0), Stretch(200, open=True)])
        response.kick(1, kick)
        return response(motor)[0]

    plain, kicked = speed(0.0), speed(5.0)
    np.testing.assert_array_equal(kicked[:199], plain[:199])
    # coasting obeys J dw/dt = -B w - T0: the jump decays with B/J
    late = np.exp(-3e-7 / 3.9e-7 * 190 * h)
    np.testing.assert_allclose(kicked[390] - plain[390], 5.0 * late, rtol=1e-3)
    np.testing.assert_array_equal(speed(-1e4), plain)


def test_a_late_on_part_is_the_same_wave_later() -> None:
    """Steady ripple of an instant current, read at a phase, against one that begins on time."""
    R, L, h, period = 1.0, 1e-3, 1e-4, 5e-5
    volts, late = np.full(2000, 3.0), 2e-6

    def settled(late_s: float, phase: float) -> float:
        stretch = Stretch(0, duty=0.3, swing_v=10.0, late_s=late_s)
        response = Response(
            h, volts, [Output(Quantity.CURRENT, pwm_phase=phase)], [stretch], period
        )
        return float(response((R, L, 1e-6, 0.0, 1.0, 0.0))[0][-1])

    for phase in (0.0, 0.02, 0.2, 0.33, 0.9):
        later = (phase + late / period) % 1.0
        assert settled(late, later) == pytest.approx(settled(0.0, phase), rel=1e-9)


def test_a_longer_delay_is_an_earlier_place_in_the_pwm_period() -> None:
    """The ripple is read where it was that much before."""
    duty, pwm_s, late_s = 0.5, 5e-5, 5e-6
    stretch = Stretch(0, duty=duty, swing_v=12.0)
    here = Output(Quantity.CURRENT, delay_s=10e-6, pwm_phase=0.1)
    there = Output(Quantity.CURRENT, delay_s=10e-6, pwm_phase=0.0)
    wraps = here.delayed(2 * late_s, pwm_s)
    assert (wraps.delay_s, wraps.pwm_phase) == pytest.approx((20e-6, 0.9))
    moved = here.delayed(late_s, pwm_s)
    readings = Response(1e-3, np.full(50, 6.0), [here, there, moved], [stretch], pwm_s)(
        [0.1, 180e-6, 7.68e-3, 3e-7, 3.9e-7, 3e-4]
    )
    rise = 12.0 * duty / 180e-6 * late_s  # A, of the on part's ramp
    assert readings[0, 40] - readings[1, 40] == pytest.approx(rise, rel=0.01)
    assert readings[2, 40] == pytest.approx(readings[1, 40], abs=0.02 * rise)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Response, WideResponse])
def test_a_response_is_worth_many_where_the_motor_starts_and_stops_all_the_time(kind) -> None:
    v = np.tile([1.0, 1.0, 0.0, 0.0], 2000)
    response = kind(1e-3, v, [Output(Quantity.SPEED)])
    more = (0.0,) * (len(NAMES) - 6) if kind is WideResponse else ()
    R, L, K, B, J, _ = FAULHABER
    response((R, L, K, B, J, 0.0, *more))
    assert response.worth == 1
    response((R, L, K, B, 1e-3 * J, 0.9 * K / R, *more))
    assert response.worth > 10
