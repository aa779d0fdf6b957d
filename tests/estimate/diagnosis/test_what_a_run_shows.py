"""What a run shows before it is fitted: readings, additions and facts, by other ways."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, POSITION, SPEED, SUPPLY, TORQUE, VOLTAGE
from motorid.estimate.diagnosis import identifiability as module
from motorid.estimate.diagnosis.identifiability import (
    COAST,
    COMBINATIONS,
    LEVELS,
    MOTION,
    TIMES_S,
    TRANSIENT,
    TYPICAL,
    Excitation,
    of_capture,
)
from tests.estimate.partial.truth import Plant, capture, closed_loop, steps

Floats = NDArray[np.float64]
MOTOR = {"R": 1.0, "L": 2e-3, "K": 0.05, "B": 1e-4, "J": 2e-5, "T0": 5e-3}
MOVED = {"R": 1.2, "L": 3e-3, "K": 0.06, "B": 2e-4, "J": 3e-5, "T0": 4e-3}
WITH_VOLTS = Excitation(frozenset({VOLTAGE, CURRENT, SPEED}))
BY_CURRENT = Excitation(frozenset({CURRENT, SPEED}))
BY_TORQUE = Excitation(frozenset({CURRENT, TORQUE, SPEED}))


def by_integration(run: Excitation, start: Floats, volts: float) -> Floats:
    """States at TIMES_S, by scipy's integrator."""
    electric = MOVED if run.sees_voltage else MOTOR
    constant = MOTOR["K"] if TORQUE in run.channels else MOVED["K"]

    def slope(_: float, x: Floats) -> list[float]:
        m = electric
        rates = [
            (volts - m["R"] * x[0] - m["K"] * x[1]) / m["L"],
            (m["K"] * x[0] - m["B"] * x[1] - m["T0"]) / m["J"],
        ]
        if len(x) > 2:
            push = constant * x[0] - MOVED["B"] * x[2] - MOVED["T0"]
            rates.append(push / MOVED["J"])
        return rates

    found = solve_ivp(slope, (0.0, TIMES_S[-1]), start, t_eval=TIMES_S, rtol=1e-9, atol=1e-9)
    return found.y.T


@pytest.mark.parametrize(
    ("channels", "columns"),
    [
        ({VOLTAGE, CURRENT, SPEED}, (0, 1)),
        ({SUPPLY, CURRENT, POSITION}, (0, 1)),
        ({VOLTAGE, CURRENT}, (0,)),
        ({VOLTAGE, SPEED}, (1,)),
        ({CURRENT, SPEED}, (1,)),
        ({TORQUE, SPEED}, (1,)),
        ({SPEED}, ()),
        ({CURRENT}, ()),
    ],
)
def test_channels_that_the_model_predicts_are_in_units_of_their_peaks(
    channels: set[str], columns: tuple[int, ...]
) -> None:
    """The current of a held rotor at 6 V is 1, and so is the speed of an idle one."""
    part = np.array([[6.0 / MOTOR["R"], 6.0 / MOTOR["K"]], [3.0, 60.0]])
    units = np.array([[1.0, 1.0], [0.5, 0.5]])
    shown = module._shown(Excitation(frozenset(channels)), MOTOR, part)
    assert len(shown) == len(columns)
    for column, values in zip(columns, shown, strict=True):
        assert values == pytest.approx(units[:, column])


def length(count: int, *channels: str, **facts: bool) -> int:
    run = Excitation(frozenset(channels), count, **facts)
    return len(module._readings(run, MOTOR, MOTOR, 1.0))


def test_readings_are_of_each_level_and_of_the_coast() -> None:
    times = len(TIMES_S)
    assert length(2, VOLTAGE, CURRENT, coast=False) == 1 + 2 * times
    assert length(2, VOLTAGE, CURRENT, coast=False, transient=False) == 1 + 2
    assert length(0, VOLTAGE, CURRENT, SPEED) == 1 + 2 * times  # the voltage is the back-EMF
    assert length(0, CURRENT, SPEED) == 1 + times
    assert length(0, VOLTAGE) == 1 + times
    assert length(0, SUPPLY, CURRENT) == 1


def test_a_coast_begins_at_most_of_the_speed_of_the_middle_level() -> None:
    run = Excitation(frozenset({VOLTAGE, SPEED}), levels=0)
    both = module._readings(run, MOTOR, MOVED, 1.1)
    speed, volts = both[1 : 1 + len(TIMES_S)], both[1 + len(TIMES_S) :]
    first = 0.8 * 6.0 / MOTOR["K"]
    assert speed == pytest.approx(module._coasting(MOVED, 1.1 * first) / first)
    assert speed[0] == pytest.approx(1.1)
    assert volts == pytest.approx(speed * MOVED["K"] / MOTOR["K"])


def test_the_speed_at_which_a_coast_begins_tells_nothing() -> None:
    """Sensitivities have no part along it: dω/dω(0) = exp(-B t/J) while it turns."""
    run = Excitation(frozenset({SPEED}), levels=0)
    scale = np.array([MOTOR[name] for name in module.PARAMETERS])
    found = module._sensitivities(run, MOTOR, scale)
    first = 0.8 * 6.0 / MOTOR["K"]
    turning = module._coasting(MOTOR, first) > 0.0
    decay = np.where(turning, np.exp(-MOTOR["B"] / MOTOR["J"] * TIMES_S), 0.0)
    assert not turning.all()
    by_inertia = TIMES_S * MOTOR["B"] / MOTOR["J"] * (1 + MOTOR["T0"] / MOTOR["B"] / first) * decay
    left = by_inertia - decay * (decay @ by_inertia) / (decay @ decay)
    np.testing.assert_allclose(found[1:, 4], left, rtol=1e-4, atol=1e-6)
    assert np.abs(decay @ found[1:]).max() < 1e-6 * np.abs(found).max()


def test_sensitivities_of_steady_levels_are_those_of_two_equations() -> None:
    """V = R i + K ω, K i = B ω + T0, differentiated by each parameter."""
    run = Excitation(frozenset({VOLTAGE, CURRENT, SPEED}), 2, transient=False, coast=False)
    scale = np.array([MOTOR[name] for name in module.PARAMETERS])
    found = module._sensitivities(run, MOTOR, scale)
    system = np.array([[MOTOR["R"], MOTOR["K"]], [MOTOR["K"], -MOTOR["B"]]])
    expected = [np.zeros((1, 6))]
    for volts in (3.0, 6.0):
        i, w = np.linalg.solve(system, [volts, MOTOR["T0"]])
        rest = [[i, 0, w, 0, 0, 0], [0, 0, i, -w, 0, -1.0]]
        moves = -np.linalg.solve(system, np.array(rest)) * scale
        expected.append(moves * [[MOTOR["R"] / 6.0], [MOTOR["K"] / 6.0]])
    np.testing.assert_allclose(found, np.vstack(expected), rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "powers"),
    [
        ("J/K", {"J": 1, "K": -1}),
        ("B/K", {"B": 1, "K": -1}),
        ("T0/K", {"T0": 1, "K": -1}),
        ("T0·R/K", {"T0": 1, "R": 1, "K": -1}),
        ("B/J", {"B": 1, "J": -1}),
        ("T0/J", {"T0": 1, "J": -1}),
        ("J/K²", {"J": 1, "K": -2}),
        ("B/K²", {"B": 1, "K": -2}),
        ("K/(JL)", {"K": 1, "J": -1, "L": -1}),
    ],
)
def test_a_product_changes_by_its_powers(name: str, powers: dict[str, int]) -> None:
    scale = np.array([MOTOR[n] for n in module.PARAMETERS])
    expected = np.array([powers.get(n, 0) for n in module.PARAMETERS], float)
    found = module._slope(COMBINATIONS[name], MOTOR, scale)
    np.testing.assert_allclose(found, expected / np.linalg.norm(expected), atol=1e-6)
    assert not module._slope(lambda _: 3.0, MOTOR, scale).any()


def test_sums_are_the_coefficients_of_the_motor() -> None:
    """Of the characteristic polynomial, and of the gain from volts to speed."""
    m = MOTOR
    system = np.array([[-m["R"] / m["L"], -m["K"] / m["L"]], [m["K"] / m["J"], -m["B"] / m["J"]]])
    assert COMBINATIONS["R/L+B/J"](m) == pytest.approx(-np.trace(system))
    assert COMBINATIONS["(RB+K²)/(JL)"](m) == pytest.approx(np.linalg.det(system))
    gain = -np.linalg.solve(system, [1.0 / m["L"], 0.0])[1]
    assert COMBINATIONS["K/(K²+RB)"](m) == pytest.approx(gain)
    assert COMBINATIONS["K+RB/K"](m) == pytest.approx(1.0 / gain)


def test_a_run_that_shows_nothing_tells_nothing() -> None:
    known = module.assess(Excitation(frozenset({SUPPLY}), levels=0))
    assert (known.parameters, known.combinations, known.null_directions) == ((), (), 6)
    assert known.missing == tuple(TYPICAL)


def test_what_is_added_joins_what_is_there() -> None:
    bare = Excitation(frozenset({CURRENT}), levels=1, transient=False, coast=False)
    assert module._with(bare, ()) == bare
    assert module._with(bare, (MOTION, VOLTAGE)).channels == {CURRENT, SPEED, VOLTAGE}
    assert module._with(bare, (LEVELS,)).levels == 3
    assert module._with(Excitation(frozenset(), levels=5), (LEVELS,)).levels == 5
    assert module._with(bare, (TRANSIENT,)).transient
    assert module._with(bare, (COAST,)).coast
    whole = Excitation(frozenset({CURRENT}))
    assert module._with(whole, (COAST, TRANSIENT, LEVELS)) == whole
    assert module._with(whole, ()) == whole


def test_the_typical_motor_is_that_of_its_data_sheet_and_is_seen_from_start_to_stop() -> None:
    """Faulhaber 2338S006S: 6 V, 2.6 Ω, 180 µH, 7.68 mN·m/A, 3.9 g·cm²; about 70 mA without load."""
    m = TYPICAL
    assert m["R"] == pytest.approx(2.6)
    assert m["L"] == pytest.approx(180e-6)
    assert m["K"] == pytest.approx(7.68e-3)
    assert m["J"] == pytest.approx(3.9 * 1e-7)
    idle = 6.0 / m["K"]
    assert 0.05 < (m["B"] * idle + m["T0"]) / m["K"] < 0.1
    stop = m["J"] / m["B"] * np.log1p(0.8 * idle * m["B"] / m["T0"])
    assert 0.0 == TIMES_S[0] < TIMES_S[1] < m["L"] / m["R"] < TIMES_S[-1]
    assert 0.5 * TIMES_S[-1] < 0.4 < stop < 3.0 * TIMES_S[-1]
    assert np.all(np.diff(TIMES_S) > 0.0)


def test_an_inductance_that_no_sample_shows_is_not_promised() -> None:
    """Its time constant is a billionth of the shortest time."""
    motor = {**MOTOR, "L": 1e-14}
    run = Excitation(frozenset({VOLTAGE, CURRENT, SPEED}))
    assert module.advice(run, motor) == "No run of this kind determines L."


def test_names_are_listed_and_times_are_short() -> None:
    assert module._list(("R",)) == "R"
    assert module._list(["R", "L"]) == "R and L"
    assert module._list(("R", "L", "K")) == "R, L and K"
    assert [module._time(s) for s in (0.012, 0.9994, 1.0, 2.34)] == [
        "12 ms", "1e+03 ms", "1 s", "2.3 s",
    ]  # fmt: skip


@pytest.mark.parametrize(("second", "levels"), [(103.0, 1), (110.0, 2)])
def test_levels_of_a_capture_are_speeds_that_differ(second: float, levels: int) -> None:
    t, i, w = closed_loop(Plant(), steps(1.0, 100.0, second), 0.02, 2.0)
    shown = of_capture(capture(t, current=("A", i), speed=("rad/s", w)))
    assert (shown.levels, shown.transient, shown.coast) == (levels, True, False)


def test_a_coast_down_shows_no_level() -> None:
    time = np.arange(0.0, 0.4, 1e-3)
    slower = np.maximum(80.0 * np.exp(-time / 0.1) - 10.0, 0.0)
    noise = 0.02 * np.random.default_rng(1).standard_normal((2, len(time)))
    shown = of_capture(capture(time, current=("A", 1e-3 * noise[0]), speed=("rad/s", slower)))
    assert (shown.levels, shown.transient, shown.coast) == (0, False, True)
