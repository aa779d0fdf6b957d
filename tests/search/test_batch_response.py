"""The batch response against scipy: matrix exponentials, filters and stiff integrators."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from scipy import integrate, linalg, signal

from motorid.errors import UsageError
from motorid.motor.batch import FRICTION, LINEAR, TWO_MASS, Record, blank, expm, quadratic

MOTOR = {"R": 3.1363, "L": 0.01307, "K": 0.048774, "B": 1.69e-4, "J": 9e-6}
LOADED = {"R": 42.5, "L": 8e-2, "c": 0.4781, "J": 2e-5, "Ta": 1e-2, "Tb": 3.27e-5, "Tc": 8.55e-8}
MASSES = {"J1": 0.00274, "J2": 0.00256, "Ks": 43.456, "b": 0.04}
VOLTS = np.concatenate([np.full(200, 8.0), np.full(100, -3.0), np.zeros(100)])


def row(values: dict[str, float]) -> np.ndarray:
    return np.array([list(values.values())])


def silent(period: float, drive: np.ndarray, channels: tuple[str, ...], **more) -> Record:
    return Record(period, drive, blank(drive, channels), **more)


@pytest.mark.slow
@settings(max_examples=50)
@given(
    arrays.arrays(np.float64, (3, 4, 4), elements=st.floats(-30, 30, allow_subnormal=False)),
)
def test_exponentials_are_scipys(matrices):
    for mine, matrix in zip(expm(matrices), matrices, strict=True):
        theirs = linalg.expm(matrix)
        assert np.abs(mine - theirs).max() <= 1e-10 * np.abs(theirs).max()


def test_linear_response_is_the_exact_discretisation():
    R, L, K, B, J = MOTOR.values()
    system = (
        np.array([[-R / L, -K / L], [K / J, -B / J]]),
        np.array([[1 / L], [0.0]]),
        np.eye(2),
        np.zeros((2, 1)),
    )
    _, expected, _ = signal.dlsim(signal.cont2discrete(system, 1e-4), VOLTS)
    record = silent(1e-4, VOLTS, ("speed", "current"))
    speed, current = LINEAR.outputs(row(MOTOR), record)[0]
    assert current == pytest.approx(expected[:, 0], abs=1e-12)
    assert speed == pytest.approx(expected[:, 1], abs=1e-10)


def test_position_is_the_integral_of_speed():
    channels = ("speed", "position")
    speed, position = LINEAR.outputs(row(MOTOR), silent(1e-5, VOLTS, channels))[0]
    area = integrate.cumulative_trapezoid(speed, dx=1e-5, initial=0.0)
    assert position == pytest.approx(area, abs=1e-5 * np.abs(position).max())


def test_two_masses_follow_equation_22():
    J1, J2, Ks, b = MASSES.values()
    transfer = ([J2, b, Ks], [J1 * J2, (J1 + J2) * b, (J1 + J2) * Ks, 0.0])
    torque = np.repeat([0.2, -0.2, 0.2, 0.2, -0.2], 40)
    discrete = signal.cont2discrete(signal.tf2ss(*transfer), 1e-3)
    _, expected, _ = signal.dlsim(discrete, torque)
    motor, load = TWO_MASS.outputs(row(MASSES), silent(1e-3, torque, ("speed", "load_speed")))[0]
    assert motor == pytest.approx(expected[:, 0], abs=1e-9 * np.abs(expected).max())
    momentum = J1 * motor + J2 * load  # the spring and its damper are inside
    assert np.diff(momentum) == pytest.approx(1e-3 * torque[:-1], abs=1e-12)


def loaded_by_lsoda(values: dict[str, float], period: float, drive: np.ndarray) -> np.ndarray:
    """Current and speed at the samples, the start found as an event."""
    R, L, c, J, Ta, Tb, Tc = values.values()

    def held(t, x, v):
        return [(v - R * x[0]) / L, 0.0]

    def turning(t, x, v):
        i, w = x
        return [(v - R * i - c * w) / L, (c * i - Ta - Tb * w - Tc * w * w) / J]

    def breaks(t, x, v):
        return c * x[0] - Ta

    breaks.terminal = True
    out, x, moving = [np.zeros(2)], np.zeros(2), False
    for v in drive[:-1]:
        t = 0.0
        if not moving:
            run = integrate.solve_ivp(
                held, (0.0, period), x, args=(v,), events=breaks, rtol=1e-11, atol=1e-13
            )
            t, x, moving = run.t[-1], run.y[:, -1], run.status == 1
        if moving and t < period:
            run = integrate.solve_ivp(
                turning, (t, period), x, args=(v,), method="LSODA", rtol=1e-11, atol=1e-12
            )
            x = run.y[:, -1]
        out.append(x)
    return np.array(out).T


def test_quadratic_load_follows_lsoda_through_its_start():
    drive = np.repeat([0.5, 20.0, 45.0, 90.0], 15)  # at .5 V the rotor cannot start at first
    expected = loaded_by_lsoda(LOADED, 5e-4, drive)
    record = silent(5e-4, drive, ("current", "speed"))
    for substeps, tolerance in ((4, 1e-5), (64, 1e-9)):
        found = quadratic(substeps).outputs(row(LOADED), record)[0]
        peak = np.abs(expected).max(axis=1, keepdims=True)
        assert np.abs((found - expected) / peak).max() < tolerance


def test_a_held_rotor_stays_and_its_current_settles():
    record = silent(5e-4, np.full(100, 0.3), ("current", "speed"))  # c v/R < Ta
    current, speed = quadratic(2).outputs(row(LOADED), record)[0]
    assert (speed == 0.0).all()
    assert current[-1] == pytest.approx(0.3 / LOADED["R"], rel=1e-6)


def test_friction_without_friction_is_the_linear_motor():
    channels = ("current", "speed", "position")
    record = silent(1e-4, VOLTS, channels)
    plain = LINEAR.outputs(row(MOTOR), record)[0]
    found = FRICTION.outputs(row({**MOTOR, "T0": 0.0}), record)[0]
    assert np.abs(found - plain).max() < 1e-9


def test_coast_follows_equation_12_and_stops():
    motor = {**MOTOR, "T0": 2e-3}
    drive = np.concatenate([np.full(600, 8.0), np.zeros(2200)])
    opened = np.arange(2800) >= 600
    record = silent(1e-4, drive, ("current", "speed"), open=opened)
    current, speed = FRICTION.outputs(row(motor), record)[0]
    first, t = speed[600], 1e-4 * np.arange(2200)
    drop = motor["T0"] / motor["B"]
    expected = np.maximum((first + drop) * np.exp(-motor["B"] / motor["J"] * t) - drop, 0.0)
    assert speed[600:] == pytest.approx(expected, abs=1e-9 * first)
    assert speed[-1] == 0.0
    assert (current[601:] == 0.0).all()


def test_friction_stops_a_reversal_at_zero_and_lets_it_start_again():
    motor = {**MOTOR, "T0": 5e-3}
    drive = np.concatenate([np.full(500, 8.0), np.full(1000, -0.2), np.full(500, -8.0)])
    current, speed = FRICTION.outputs(row(motor), silent(1e-4, drive, ("current", "speed")))[0]
    assert speed[499] > 50.0
    assert (speed[1000:1500] == 0.0).all()  # .2 V cannot break it away
    assert current[1499] == pytest.approx(-0.2 / motor["R"], rel=1e-6)
    assert speed[-1] < -50.0


def test_a_current_is_read_as_the_mean_over_its_aperture():
    motor = {**MOTOR, "T0": 1e-3}
    fine, ratio = 1e-6, 100
    drive = np.full(30, 8.0)
    (dense,) = FRICTION.outputs(row(motor), silent(fine, np.repeat(drive, ratio), ("current",)))[0]
    area = integrate.cumulative_trapezoid(dense, dx=fine, initial=0.0)
    ends = ratio * np.arange(1, 30) - 7  # 7 µs late, 50 µs long
    expected = (area[ends] - area[ends - 50]) / 5e-5
    record = silent(1e-4, drive, ("current",), current_aperture_s=5e-5, current_delay_s=7e-6)
    (found,) = FRICTION.outputs(row(motor), record)[0]
    assert found[1:] == pytest.approx(expected, rel=2e-4)


def test_a_lag_reads_between_the_samples():
    at_once = LINEAR.outputs(row(MOTOR), silent(1e-4, VOLTS, ("speed",)))[0, 0]
    late = LINEAR.outputs(row(MOTOR), silent(1e-4, VOLTS, ("speed",), lag_s={"speed": 4e-5}))[0, 0]
    assert late[1:] == pytest.approx(0.6 * at_once[1:] + 0.4 * at_once[:-1])


@pytest.mark.parametrize("n", [1, 7, 8, 9, 23])
def test_a_candidate_does_not_feel_its_neighbours(n):
    clean = LINEAR.outputs(row(MOTOR), silent(1e-4, VOLTS, ("current", "speed")))[0]
    record = Record(1e-4, VOLTS, {"current": clean[0], "speed": clean[1]})
    motors = row(MOTOR) * np.random.default_rng(0).uniform(0.3, 3.0, (n, 5))
    together = LINEAR.squares(motors, record)
    alone = np.vstack([LINEAR.squares(motor[None], record) for motor in motors])
    assert np.array_equal(together, alone)
    outputs = LINEAR.outputs(motors, record)
    assert together == pytest.approx(((outputs - clean) ** 2).sum(axis=2), rel=1e-10)


def test_missing_readings_count_for_nothing():
    clean = LINEAR.outputs(row(MOTOR), silent(1e-4, VOLTS, ("current", "speed")))[0]
    holes = clean + 0.1
    holes[0, 50:150] = np.nan
    record = Record(1e-4, VOLTS, {"current": holes[0], "speed": holes[1]})
    squares = LINEAR.squares(row(MOTOR), record)[0]
    assert squares == pytest.approx([0.01 * (len(VOLTS) - 100), 0.01 * len(VOLTS)])


def test_a_motor_that_blows_up_costs_without_limit_and_alone():
    record = Record(1e-4, VOLTS, {"speed": np.zeros(len(VOLTS))})
    wild = {**MOTOR, "R": -3000.0}
    squares = LINEAR.squares(np.vstack([row(MOTOR), row(wild), row(MOTOR)]), record)[:, 0]
    assert squares[0] == squares[2]
    assert np.isfinite(squares[0])
    assert not squares[1] < 1e100


def test_a_channel_that_the_model_lacks_is_named():
    with pytest.raises(UsageError, match="two masses model has no channel current"):
        TWO_MASS.squares(row(MASSES), silent(1e-3, VOLTS, ("current",)))
