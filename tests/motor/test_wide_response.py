"""The compiled wider response against SciPy, and against the six-parameter one."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.motor.reading import Output, Quantity, Stretch
from motorid.motor.response import Response
from motorid.motor.wide import AT_REST, NAMES, SIX, WideResponse
from tests.motor.wide_reference import WideReference

MOTOR = {"R": 2.6, "L": 180e-6, "K": 7.68e-3, "B": 3e-7, "J": 3.9e-7, "T0": 3e-4}
PERIOD_S = 1e-4
TERMS = {
    "brush": {"brush": 0.3, "brush_current": 0.1},
    "quadratic": {"quadratic": 3e-10},
    "direction": {"asymmetry": 0.3},
    "stribeck": {"stiction": 2e-4, "stribeck": 40.0},
    "cogging": {"cogging": 2e-4, "cogging_per_turn": 10.0},
    "ripple": {"k_ripple": 0.04, "r_ripple": 0.03, "ripple_per_turn": 10.0},
    "heat": {"warming": 2.0, "cooling": 1.0},  # so fast that it shows in these few samples
    "two masses": {"J": 2e-7, "load_inertia": 2e-7, "stiffness": 0.02, "damping": 1e-6},
    "emf": {"emf": 0.05},
    "load friction": {"load_friction": 0.05},
    "reaction": {"reaction": 0.04, "reaction_bend": 0.2},
    "saturation": {"saturation": 0.6, "saturation_current": 0.8},
    "eddy": {"eddy": 0.5, "eddy_time": 2e-4},
    "commutation": {"commutation": 3e-4},
    "brushes that lift": {"commutation": 1e-3, "commutation_from": 300.0},
    "drift": {"drift": 4e-4, "drift_rate": 200.0, "drift_span": 0.02},
    "iron": {"saturation": 0.6, "saturation_current": 0.8, "eddy": 0.5, "eddy_time": 1e-4},
}
TERMS["all"] = {name: value for term in TERMS.values() for name, value in term.items()}
READINGS = [
    Output(Quantity.CURRENT, 0.5 * PERIOD_S, 0.2 * PERIOD_S),
    Output(Quantity.CURRENT, 2.3 * PERIOD_S, 1.4 * PERIOD_S),
    Output(Quantity.SPEED, 0.0, 0.3 * PERIOD_S),
    Output(Quantity.SPEED, PERIOD_S),
    Output(Quantity.POSITION, 0.0, 0.0),
]
# rest, a start, a reversal, a coast whose current freewheels
VOLTS = np.concatenate([np.zeros(5), np.full(75, 6.0), np.full(80, -4.0), np.zeros(35)])
PLAN = [Stretch(0, True), Stretch(5), Stretch(160, True, clamp_v=7.0)]


def vector(**added: float) -> list[float]:
    return [{**MOTOR, **added}.get(name, 0.0) for name in NAMES]


def against(reference: WideReference, response: WideResponse, motor: list[float]) -> float:
    """Largest difference over all readings, relative to each reading's range."""
    ours = response(motor, (*AT_REST[:4], *reference.phases))
    errors = []
    for output, y in zip(READINGS, ours, strict=True):
        z = reference.read(output, np.arange(len(VOLTS)) * PERIOD_S)
        errors.append(np.abs(y - z).max() / np.abs(z).max())
    return max(errors)


@pytest.mark.slow
@pytest.mark.parametrize("term", TERMS)
def test_every_term_agrees_with_scipy(term: str) -> None:
    added = TERMS[term]
    reference = WideReference({**MOTOR, **added}, phases=(0.4, 1.1))
    reference.run(PERIOD_S, VOLTS, PLAN)
    response = WideResponse(PERIOD_S, VOLTS, READINGS, PLAN)
    start = (*AT_REST[:4], *reference.phases)
    response.plan(vector(**added), start, 1e-10)
    assert against(reference, response, vector(**added)) < 1e-8
    response.plan(vector(**added), start)  # as a fit does
    assert against(reference, response, vector(**added)) < 1e-5


def test_halving_the_steps_divides_the_error_as_the_order_says() -> None:
    motor = vector(**TERMS["cogging"], **TERMS["quadratic"])
    response = WideResponse(PERIOD_S, VOLTS, READINGS, PLAN)
    answers = []
    for level in (0, 1, 2, 5):
        response.levels[:] = level
        answers.append(response(motor)[3])
    *coarse, fine = answers
    errors = [np.abs(y - fine).max() for y in coarse]
    assert errors[0] / errors[1] > 2**3
    assert errors[1] / errors[2] > 2**3


def test_without_terms_it_is_the_six_parameter_response() -> None:
    plan = [Stretch(0, True), Stretch(5, duty=0.8, swing_v=7.5), Stretch(160, True, clamp_v=7.0)]
    outputs = [*READINGS, Output(Quantity.CURRENT, 0.0, 1e-5, 0.3)]
    six = Response(PERIOD_S, VOLTS, outputs, plan, PERIOD_S / 2)(tuple(MOTOR.values()))
    wide = WideResponse(PERIOD_S, VOLTS, outputs, plan, PERIOD_S / 2)(vector())
    np.testing.assert_allclose(wide, six, rtol=1e-9, atol=1e-9 * np.abs(six).max())


def test_a_current_that_stops_has_no_memory_in_the_wide_response_either() -> None:
    pulses = Stretch(5, duty=0.4, swing_v=13.4, clamp_v=7.4, discontinuous=True)
    plan = [Stretch(0, True), pulses, Stretch(80), Stretch(160, True, clamp_v=7.0)]
    outputs = [*READINGS, Output(Quantity.CURRENT, 0.0, 1e-5, 0.3)]
    six = Response(PERIOD_S, VOLTS, outputs, plan, PERIOD_S / 2)(tuple(MOTOR.values()))
    wide = WideResponse(PERIOD_S, VOLTS, outputs, plan, PERIOD_S / 2)(vector())
    np.testing.assert_allclose(wide, six, atol=2e-3 * np.abs(six).max(axis=1).min())


def test_a_rotor_that_stands_does_so_in_the_wide_response_too() -> None:
    plan = [Stretch(0, True), Stretch(5, still=True), Stretch(40), Stretch(160, True, clamp_v=7.0)]
    six = Response(PERIOD_S, VOLTS, READINGS, plan)(tuple(MOTOR.values()))
    wide = WideResponse(PERIOD_S, VOLTS, READINGS, plan)(vector())
    np.testing.assert_allclose(wide, six, rtol=1e-9, atol=1e-9 * np.abs(six).max())


def test_stiction_holds_until_it_is_overcome() -> None:
    """K i rises with L/R: motion begins where it passes T0 and stiction, not T0 alone."""
    v = np.concatenate([np.zeros(2), np.full(198, 0.15)])
    hold = {"stiction": 3e-4, "stribeck": 1.0}
    speed = [Output(Quantity.SPEED)]
    plan = [Stretch(0, True), Stretch(2)]
    free = WideResponse(PERIOD_S, v, speed, plan)(vector())
    held = WideResponse(PERIOD_S, v, speed, plan)(vector(**hold))
    stall_torque = MOTOR["K"] * 0.15 / MOTOR["R"]
    assert MOTOR["T0"] < stall_torque < MOTOR["T0"] + hold["stiction"]
    assert free.max() > 1.0
    assert held.max() == 0.0


def test_cogging_at_an_angle_that_is_given_is_a_torque() -> None:
    """A rotor said to stay at one angle: what cogging adds there is as constant as friction."""
    v = np.concatenate([np.zeros(5), np.full(195, 4.0)])
    plan, phase = [Stretch(0, True), Stretch(5)], 0.4
    wide = WideResponse(PERIOD_S, v, READINGS, plan)
    wide.angle = np.full(len(v), 0.3)
    cogged = wide(vector(cogging=2e-4, cogging_per_turn=4.0), (*AT_REST[:4], phase, 0.0))
    rubbed = {**MOTOR, "T0": MOTOR["T0"] + 2e-4 * np.sin(4 * 0.3 + phase)}
    six = Response(PERIOD_S, v, READINGS, plan)(tuple(rubbed.values()))
    np.testing.assert_allclose(cogged, six, rtol=1e-9, atol=1e-9 * np.abs(six).max())
    wide.angle = np.zeros(3)
    with pytest.raises(ValueError, match="angles"):
        wide(vector())


def test_the_models_own_angle_may_be_given_as_well() -> None:
    start = (*AT_REST[:4], 0.4, 1.1)
    wide = WideResponse(PERIOD_S, VOLTS, READINGS, PLAN)
    wide.plan(vector(**TERMS["cogging"], **TERMS["ripple"]), start)
    own = wide(vector(**TERMS["cogging"], **TERMS["ripple"]), start)
    wide.angle = own[4].copy()
    given = wide(vector(**TERMS["cogging"], **TERMS["ripple"]), start)
    apart = np.abs(given - own).max(axis=1) / np.abs(own).max(axis=1)
    assert 0.0 < apart.max() < 2e-3


@pytest.mark.parametrize("added", [{"R": -1.0}, {"brush": 0.1}, {"stiction": 1e-4}])
def test_refuses_a_motor_that_cannot_be(added: dict[str, float]) -> None:
    response = WideResponse(PERIOD_S, VOLTS, READINGS, PLAN)
    with pytest.raises(ValueError, match="no response"):
        response(vector(**added))
    assert len(SIX) == 6


@pytest.mark.slow
def test_an_absurd_motor_is_planned_roughly_and_ends_as_no_number() -> None:
    values = {"R": 4e-7, "L": 9e8, "K": 0.06, "B": 9e-14, "J": 7e-17, "T0": 4.6e-13}
    motor = vector(**values, quadratic=1.1e-7)
    response = WideResponse(3e-5, np.full(2000, 48.0), READINGS, [Stretch(0)])
    response.plan(motor, AT_REST, 1e-9)
    assert np.count_nonzero(response.levels) < 1000  # of intervals that never end to be planned
    readings = response(motor)
    assert np.isfinite(readings[:, :5]).all()
    assert np.isnan(readings[:, -1]).all()
