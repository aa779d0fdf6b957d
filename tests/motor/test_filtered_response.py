"""Readings behind a low-pass filter, against SciPy: exponentials, and a bridge that switches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import NAMES, SIX, WideResponse
from tests.motor.filter_reference import Behind, Bridge, Linear
from tests.motor.wide_reference import WideReference
from tests.motor_reference import Reference

R, L, K, B, J, T0 = FAULHABER = (2.6, 180e-6, 7.68e-3, 3e-7, 3.9e-7, 3e-4)
H = 1e-4
NO_FRICTION = (R, L, K, B, J, 0.0)
MOVING = (0.3, 20.0, 1.0)
TAUS = (1e-9, 1e-6, 2e-5, L / R, L / R * (1 + 1e-7), 1e-4, 1e-3, 0.05, 2.0)


def wide(motor) -> list[float]:
    """The six as a motor of ``WideResponse``."""
    return [dict(zip(SIX, motor, strict=True)).get(name, 0.0) for name in NAMES]


def worst(ours, theirs) -> float:
    return float(np.abs(ours - theirs).max() / np.abs(theirs).max())


@pytest.mark.parametrize("tau", TAUS)
@pytest.mark.parametrize("quantity", Quantity)
def test_a_linear_motor_agrees_with_exponentials(quantity: Quantity, tau: float) -> None:
    """Levels that last 15 ticks, and some that change with every tick as a PWM does."""
    volts = np.r_[0.0, np.repeat([4.0, -6.0, 1.5], 15), np.tile([12.0, 0.0, 0.0], 10)]
    for aperture, delay in ((0.0, 0.0), (0.0, 0.3), (0.5, 0.2), (7.3, 1.4)):
        if aperture and quantity == Quantity.POSITION:
            continue
        output = Output(quantity, aperture * H, delay * H, filter_s=tau)
        theirs = Linear(NO_FRICTION, H, volts, output, MOVING).read()
        ours = Response(H, volts, [output])(NO_FRICTION, MOVING)[0]
        wider = WideResponse(H, volts, [output])(wide(NO_FRICTION), (*MOVING, 0.0, 0.0, 0.0))[0]
        assert worst(ours, theirs) < 1e-9
        assert worst(wider, theirs) < 1e-9


@pytest.mark.parametrize("inductance", [0.0, 1e-12])
def test_a_current_without_inductance_is_filtered_alike(inductance: float) -> None:
    motor = (R, inductance, K, B, J, 0.0)
    volts = np.r_[0.0, np.full(40, 5.0)]
    outputs = [Output(Quantity.CURRENT, a, 2e-5, filter_s=3e-5) for a in (0.0, 6e-5)]
    small = (R, 1e-7, K, B, J, 0.0)
    for output, ours in zip(outputs, Response(H, volts, outputs)(motor), strict=True):
        assert worst(ours, Linear(small, H, volts, output).read()) < 2e-3


# rest, a start, a reversal, a coast that freewheels, a stop by friction, a start, a cut current
STIFF = (R, L, K, B, J, 10 * T0)  # friction that stops it soon
COURSE = np.repeat([0.0, 6.0, -6.0, 0.0, 2.0, 0.0], [5, 45, 50, 130, 20, 20])
PLAN = [
    Stretch(0, True), Stretch(5, series_ohm=0.2), Stretch(100, True, clamp_v=7.0),
    Stretch(230), Stretch(250, True),
]  # fmt: skip
READINGS = [
    Output(Quantity.CURRENT), Output(Quantity.CURRENT, 0.5 * H, 0.2 * H),
    Output(Quantity.CURRENT, 7.3 * H, 1.4 * H), Output(Quantity.SPEED, 0.0, 0.3 * H),
    Output(Quantity.SPEED, H), Output(Quantity.POSITION, 0.0, 2.25 * H),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("tau", [1e-4, 2e-3])
def test_starts_stops_and_coasts_agree_with_an_adaptive_integrator(tau: float) -> None:
    outputs = [replace(o, filter_s=tau) for o in READINGS]
    ours = Response(H, COURSE, outputs, PLAN)(STIFF)
    reference = Reference(STIFF, max_step=H)
    reference.run(H, COURSE, PLAN)
    assert np.ptp(np.sign(ours[3])) == 2.0  # it turned both ways
    assert reference.states(np.array([228 * H]))[1] == 0.0  # and friction stopped it
    filtered = Behind(reference, tau)
    for output, y in zip(outputs, ours, strict=True):
        assert worst(y, filtered.read(output, np.arange(len(COURSE)) * H)) < 1e-7


@pytest.mark.slow
def test_a_wider_motor_is_filtered_within_its_own_exactness() -> None:
    added = {
        "brush": 0.3, "brush_current": 0.1, "quadratic": 3e-10, "J": 2e-7, "load_inertia": 2e-7,
        "stiffness": 0.02, "damping": 1e-6, "cogging": 1e-4, "cogging_per_turn": 10.0,
    }  # fmt: skip
    named = {**dict(zip(SIX, FAULHABER, strict=True)), **added}
    motor = [named.get(name, 0.0) for name in NAMES]
    volts = np.r_[np.zeros(3), np.full(14, 6.0), np.zeros(10)]
    plan = [Stretch(0, True), Stretch(3), Stretch(17, True, clamp_v=7.0)]
    outputs = [replace(READINGS[k], filter_s=2e-4) for k in (2, 3, 5)]
    response = WideResponse(H, volts, outputs, plan)
    response.plan(motor, tolerance=1e-9)
    ours = response(motor)
    reference = WideReference(named)
    reference.run(H, volts, plan)
    filtered = Behind(reference, 2e-4)
    for output, y in zip(outputs, ours, strict=True):
        assert worst(y, filtered.read(output, np.arange(len(volts)) * H)) < 1e-7


T = 5e-5  # PWM period
RATIOS = np.array([0.01, 0.1, 1.0, 10.0, 100.0])  # of the filter to it
WITHIN = np.array([1e-5, 1e-8, 1e-9, 1e-9, 1e-9])  # of the ripple: the integrator's dense output


@pytest.mark.slow
@pytest.mark.parametrize("periods", [1, 2])
@pytest.mark.parametrize(
    ("duties", "diodes"), [((0.4, 0.75, 0.1), False), ((0.3, 0.4, 0.85), True)]
)
def test_ripple_agrees_with_a_bridge_that_switches(duties, diodes: bool, periods: int) -> None:
    """Ten PWM periods of each duty; a diode decay stops the current in the first two duties."""
    supply, emf, heavy = 6.0, 1.2, 1e9
    off = -supply - 1.4 if diodes else 0.0
    bridge, means = Bridge(R, L, emf, list(T * RATIOS)), []
    for duty in np.repeat(duties, 10):
        current, charge = bridge.now[:2]
        bridge.period(supply, off, duty * T, (1 - duty) * T, diodes)
        means.append(R * (bridge.now[1] - charge) / T + emf + L * (bridge.now[0] - current) / T)
    plan = [
        Stretch(1 + 10 * k // periods, duty=duty, swing_v=supply - off, clamp_v=-off,
                discontinuous=diodes and k < 2)
        for k, duty in enumerate(duties)
    ]  # fmt: skip
    h, motor, start = periods * T, (R, L, K, 0.0, heavy, 0.0), (0.0, emf / K, 0.0)
    volts = np.r_[0.0, np.reshape(means, (-1, periods)).mean(axis=1)]
    ripple = duties[0] * supply * T / L
    for aperture in (0.0, 17e-6, T):
        for phase in (0.0, 0.1, 0.3, 0.55, 0.9):
            delay = (1 - phase) * T
            outputs = [Output(Quantity.CURRENT, aperture, delay, filter_s=r * T) for r in RATIOS]
            times = np.arange(len(volts)) * h - delay
            theirs = bridge.at(times)
            if aperture:  # mean of y = (integral of x - tau (change of y)) / aperture
                change = theirs - bridge.at(times - aperture)
                seen = (change[1] - T * RATIOS[:, None] * change[2:]) / aperture
            else:
                seen = theirs[2:]
            six = Response(h, volts, outputs, plan, T)(motor, start)
            wider = WideResponse(h, volts, outputs, plan, T)(wide(motor), (*start, 0.0, 0.0, 0.0))
            assert (np.abs(six - seen).max(axis=1) < WITHIN * ripple).all()
            np.testing.assert_allclose(wider, six, atol=1e-9 * ripple)


RUN = [
    Stretch(0, True), Stretch(5, duty=0.5, swing_v=12.0), Stretch(60, duty=0.3, swing_v=26.0,
    clamp_v=13.4, discontinuous=True), Stretch(100, duty=0.2, swing_v=-12.0),
    Stretch(150, True, clamp_v=12.0),
]  # fmt: skip


def rippled(response: type[Response] = Response, filter_s: float = 0.0) -> Response:
    outputs = [replace(o, filter_s=filter_s) for o in READINGS]
    return response(H, COURSE, outputs, RUN, H / 2)


def test_a_filter_that_is_shorter_than_all_else_shows_the_quantity() -> None:
    """The pulses of a current that stops are exact to 1e-5 where no filter is."""
    plain, short = rippled()(FAULHABER), rippled(filter_s=1e-13)(FAULHABER)
    for a, b in zip(short, plain, strict=True):
        np.testing.assert_allclose(a, b, atol=2e-5 * np.abs(b).max())
    none = rippled(filter_s=1e-17)(FAULHABER)
    np.testing.assert_array_equal(none, plain)


def test_a_filter_that_is_longer_than_the_record_integrates() -> None:
    tau, volts = 1e3, np.r_[0.0, np.full(200, 4.0)]
    outputs = [Output(Quantity.CURRENT, filter_s=tau), Output(Quantity.SPEED, filter_s=tau)]
    charge = Output(Quantity.CURRENT, 200 * H)
    *slow, mean = Response(H, volts, [*outputs, charge])(NO_FRICTION)
    assert slow[0][-1] * tau == pytest.approx(mean[-1] * 200 * H, rel=1e-4)
    angle = Response(H, volts, [Output(Quantity.POSITION)])(NO_FRICTION)[0, -1]
    assert slow[1][-1] * tau == pytest.approx(angle, rel=1e-4)


@pytest.mark.parametrize("response", [Response, WideResponse])
@pytest.mark.parametrize("tau", [3e-6, 2.5e-5, L / R, 1.3e-3])
def test_readings_are_smooth_in_the_filter(response: type[Response], tau: float) -> None:
    """Central differences at two steps agree, with a filter that is changed between two runs."""
    model = rippled(response)
    motor = FAULHABER if response is Response else wide(FAULHABER)

    def slope(step: float) -> np.ndarray:
        runs = []
        for factor in (1 + step, 1 - step):
            for row in range(len(READINGS)):
                model.filter(row, tau * factor)
            runs.append(model(motor))
        return (runs[0] - runs[1]) / (2 * step)

    coarse, fine = slope(1e-4), slope(1e-5)
    scale = np.abs(fine).max(axis=1)
    assert (scale > 0.0).all()
    assert (np.abs(coarse - fine).max(axis=1) < 1e-5 * scale).all()


@pytest.mark.parametrize("response", [Response, WideResponse])
def test_a_filter_changes_its_own_row_and_may_be_taken_back(response: type[Response]) -> None:
    motor = FAULHABER if response is Response else wide(FAULHABER)
    model, late = rippled(response), 3e-5
    plain = model(motor)
    model.filter(1, 4e-5)
    model.delay(1, late)
    given = list(READINGS)
    given[1] = replace(given[1], filter_s=4e-5).delayed(late, H / 2)
    both = model(motor)
    np.testing.assert_array_equal(both, response(H, COURSE, given, RUN, H / 2)(motor))
    np.testing.assert_array_equal(np.delete(both, 1, 0), np.delete(plain, 1, 0))
    assert np.abs(both[1] - plain[1]).max() > 0.01 * np.abs(plain[1]).max()
    model.delay(1, 0.0)
    model.filter(1, 0.0)
    np.testing.assert_array_equal(model(motor), plain)


def test_a_delay_comes_after_the_filter() -> None:
    """A delay of whole ticks is the same reading so many ticks later."""
    outputs = [Output(Quantity.CURRENT, 2e-5, n * H, filter_s=7e-5) for n in (0, 3)]
    now, later = Response(H, COURSE, outputs, PLAN)(FAULHABER)
    np.testing.assert_allclose(later[3:], now[:-3], atol=1e-12 * np.abs(now).max())


def test_two_filters_are_one_of_second_order() -> None:
    """1 / (1 + a s) / (1 + b s) is a share of each; it starts with slope zero."""
    a, b = 6e-5, 4e-5
    volts = np.r_[0.0, np.full(100, 5.0)]
    outputs = [Output(Quantity.CURRENT, filter_s=tau) for tau in (a, b)]
    locked = (R, 0.0, 1e-9, 0.0, 1.0, 1.0)
    slow, fast = Response(1e-6, volts, outputs)(locked)
    t = np.arange(101) * 1e-6
    step = 5.0 / R * (1 - (a * np.exp(-t / a) - b * np.exp(-t / b)) / (a - b))
    np.testing.assert_allclose((a * slow - b * fast) / (a - b), step, atol=1e-12)
