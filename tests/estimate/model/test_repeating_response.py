"""What repeats with the rotor: its orders, phases and runs, beside the courses that it shows."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, POSITION
from motorid.estimate.effects.influence_quantity import InfluenceQuantity, Instance
from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.encoder_error import ENCODER_ERROR
from motorid.estimate.effects.rotor.friction_ripple import FRICTION_RIPPLE
from motorid.estimate.effects.rotor.k_ripple import K_RIPPLE
from motorid.estimate.effects.rotor.r_ripple import R_RIPPLE
from motorid.estimate.effects.rotor.repeating import of_order
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.repeating_response import RepeatingResponse, is_of_motor
from motorid.estimate.results.estimate import PARAMETERS
from motorid.motor.reading import Quantity
from motorid.motor.wide import NAMES, START
from tests.exact_capture import FAULHABER, Plan, clean_capture

PLAN = Plan(volts=(6.0, 3.0), count=1000, aperture_s=0.0, delay_s=0.0)
POINT = np.array(list(FAULHABER.values()))


@cache
def response(encoder: bool = True) -> RepeatingResponse:
    made = clean_capture(FAULHABER, PLAN)
    channels = {n: c for n, c in made.channels.items() if encoder or n != POSITION}
    if encoder:
        channels[POSITION] = replace(channels[POSITION], resolution=1e-4)
    record = MotorRecord(replace(made, channels=channels), PARAMETERS, {})
    return RepeatingResponse(record, POINT, np.array([u.start for u in record.unknowns]))


def sizes(periods: int, **waves: complex) -> dict[Instance, float]:
    quantities = {"K": K_RIPPLE, "R": R_RIPPLE, "T": COGGING}
    out = {}
    for name, wave in waves.items():
        cosine, sine = of_order(quantities[name], periods)
        out |= {cosine: wave.real, sine: wave.imag}
    return out


def test_an_encoders_error_moves_no_motor() -> None:
    assert all(is_of_motor(one) for q in (K_RIPPLE, R_RIPPLE, COGGING) for one in of_order(q, 3))
    assert not any(is_of_motor(one) for one in of_order(ENCODER_ERROR, 3))


@pytest.mark.parametrize("encoder", [True, False])
def test_the_angle_is_the_encoders_or_else_the_models(encoder: bool) -> None:
    true = clean_capture(FAULHABER, PLAN).channels[POSITION].values
    angle = response(encoder).angle
    assert angle.shape == (PLAN.count,)
    assert np.ptp(angle - true) < 0.02 * np.ptp(true)
    if not encoder:
        assert angle[0] == 0.0


def test_waves_are_the_two_sizes_of_an_order_and_r_is_in_phase_with_k() -> None:
    at = response()
    K, R, T = 0.03 + 0.04j, 0.02 - 0.01j, 1e-4 + 2e-4j
    assert at._waves(7, sizes(7, K=K, T=T)) == {K_RIPPLE: K, COGGING: T}
    assert at._waves(7, sizes(7, R=R)) == {R_RIPPLE: R}
    assert at._waves(8, sizes(7, K=K)) == {}
    both = at._waves(7, sizes(7, K=K, R=R))
    unit = K / abs(K)
    along = (R.conjugate() * unit).real
    assert both[R_RIPPLE] == pytest.approx(along * unit)
    assert both[K_RIPPLE] == K


@pytest.mark.parametrize(
    ("waves", "ripple", "phase"),
    [
        ({"K": 0.03 + 0.04j, "R": 0.0}, (0.05, 0.0), cmath.phase(0.03 + 0.04j)),
        ({"K": 0.03 + 0.04j, "R": -0.006 - 0.008j}, (0.05, -0.01), cmath.phase(0.03 + 0.04j)),
        ({"R": 0.01j}, (0.0, 0.01), math.pi / 2),
        ({}, (0.0, 0.0), 0.0),
    ],
)
def test_a_run_has_amplitudes_and_the_phase_of_its_ripple(
    waves: dict[str, complex], ripple: tuple[float, float], phase: float
) -> None:
    of = {"K": K_RIPPLE, "R": R_RIPPLE}
    at = response()
    motor, initial = at._run(9, {of[name]: wave for name, wave in waves.items()})
    found = dict(zip(NAMES, motor.tolist(), strict=True))
    assert (found["k_ripple"], found["r_ripple"]) == pytest.approx(ripple)
    assert found["ripple_per_turn"] == found["cogging_per_turn"] == 9
    assert found["cogging"] == 0.0
    assert [found[name] for name in PARAMETERS] == POINT.tolist()
    assert initial[START.index("ripple_phase")] == pytest.approx(phase)
    assert at._motor[len(PARAMETERS) :].tolist() == [0.0] * (len(NAMES) - len(PARAMETERS))


def test_cogging_is_a_sine_that_is_taken_away() -> None:
    """-T sin(n a + p) = T cos(n a): p is a quarter before the phase of the wave."""
    motor, initial = response()._run(5, {COGGING: 2e-4j})
    found = dict(zip(NAMES, motor.tolist(), strict=True))
    p, angle = initial[START.index("cogging_phase")], 0.3
    assert found["cogging"] == pytest.approx(2e-4)
    shown = -found["cogging"] * math.sin(5 * angle + p)
    assert shown == pytest.approx((2e-4j * cmath.exp(1j * 5 * angle)).real)


def test_bends_of_all_orders_of_the_motor_add_up() -> None:
    at = object.__new__(RepeatingResponse)
    asked: list[int] = []

    def bend(periods: int, *_: Any) -> dict[str, np.ndarray]:
        asked.append(periods)
        return {CURRENT: np.full(3, float(periods))}

    at.bend = bend  # type: ignore[method-assign]
    of = (of_order(K_RIPPLE, 7), of_order(COGGING, 9), of_order(ENCODER_ERROR, 2))
    slopes: dict[Instance, Any] = {one: {} for pair in of for one in pair}
    assert at.bends(slopes, {})[CURRENT].tolist() == [16.0] * 3
    assert asked == [7, 9]
    assert at.bends({}, {}) == {}


def test_what_judges_the_drive_has_the_ripple_of_the_run() -> None:
    """For some per cent it is the slope times the size, of the current at the ticks."""
    at = response()
    record, wave = at.record, sizes(7, K=0.01 + 0.005j)
    row = [(o.quantity, o.aperture_s) for o in record.driving.asked].index((Quantity.CURRENT, 0.0))
    before = record.simulated
    course = at.course(wave)
    assert record.simulated == before + 2
    assert course.shape == (len(record.driving.asked), PLAN.count)
    slopes = at.slopes(7)
    block = record.block(CURRENT)
    assert block is not None
    expected = sum(size * slopes[one][CURRENT] for one, size in wave.items())
    apart = course[row][block.keep] - expected
    assert np.abs(expected).max() > 0.01
    assert np.abs(apart).max() < 0.1 * np.abs(expected).max()
    assert not at.course({of_order(ENCODER_ERROR, 1)[0]: 1.0}).any()
    two = at.course({**wave, **sizes(9, K=0.01)}) - at.course(sizes(9, K=0.01))
    np.testing.assert_allclose(two, course, atol=1e-9)


def test_the_work_of_an_order_is_counted() -> None:
    """A plan, the run as it is, and two runs of each of four quantities."""
    at = response()
    before = at.record.simulated
    at.slopes(7)
    assert at.record.simulated == before + 10


def turning(*volts: float) -> RepeatingResponse:
    """At levels of these signs, without an encoder: the model's angle is exact."""
    made = clean_capture(FAULHABER, replace(PLAN, volts=volts))
    record = MotorRecord(made, PARAMETERS, {})
    return RepeatingResponse(record, POINT, np.array([u.start for u in record.unknowns]))


@pytest.mark.slow
@pytest.mark.parametrize(("volts", "sign"), [((6.0, 3.0), -1.0), ((-6.0, -3.0), 1.0)])
def test_one_way_friction_that_varies_is_cogging(volts: tuple[float, ...], sign: float) -> None:
    """But for when the rotor breaks away, which bends."""
    shown = turning(*volts).slopes(3)
    for rubs, cogs in zip(of_order(FRICTION_RIPPLE, 3), of_order(COGGING, 3), strict=True):
        for block, course in shown[rubs].items():
            largest = np.abs(course).max()
            assert course == pytest.approx(sign * shown[cogs][block], abs=0.05 * largest)


def _driven(level_v: tuple[float, float], each_s: float, torque: float, at: np.ndarray) -> Any:
    """The rotor's angle (n,), rad, from rest at two levels, integrated by SciPy.

    Its friction has ``torque`` sin(3 angle) less.
    """
    R, L, K, B, J, T0 = FAULHABER.values()

    def rates(t: float, x: np.ndarray) -> list[float]:
        i, speed, angle = x
        volts = level_v[0] if t < each_s else level_v[1]
        dry = (T0 - torque * math.sin(3 * angle)) * math.tanh(speed / 1e-3)
        return [(volts - R * i - K * speed) / L, (K * i - B * speed - dry) / J, speed]

    ends = ((0.0, each_s), (each_s, 2.0 * each_s))
    state, out = np.zeros(3), []
    for k, span in enumerate(ends):
        here = at[(at >= span[0]) & ((at < span[1]) | (k == 1))]
        found = solve_ivp(rates, span, state, "LSODA", np.r_[here, span[1]], rtol=1e-10, atol=1e-12)
        state = found.y[:, -1]
        out.append(found.y[2, :-1])
    return np.concatenate(out)


@pytest.mark.slow
def test_friction_that_varies_is_against_the_motion_both_ways() -> None:
    """Beside the equations of a motor whose friction is T0 - F sin 3 angle: the second unknown."""
    response = turning(6.0, -6.0)
    slopes, block = response.slopes(3), response.record.block(POSITION)
    assert block is not None

    def shown(quantity: InfluenceQuantity) -> np.ndarray:
        course = np.zeros(PLAN.count)
        course[block.keep] = slopes[of_order(quantity, 3)[1]][POSITION]
        return course[rest : rest + 2 * each]

    rest, h = PLAN.count // 20, PLAN.period_s
    each = (PLAN.count - 4 * rest) // 3
    at = np.arange(2 * each) * h
    small = 1e-3 * FAULHABER["T0"]
    with_it, without = (_driven((6.0, -6.0), each * h, f, at) for f in (small, 0.0))
    turned = (with_it - without) / small
    largest = np.abs(turned).max()
    assert largest > 0.0
    assert shown(FRICTION_RIPPLE) == pytest.approx(turned, abs=0.05 * largest)
    assert np.abs(shown(COGGING) - turned).max() > 0.2 * largest
