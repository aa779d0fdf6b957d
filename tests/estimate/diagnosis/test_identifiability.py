"""Claims about what a run can tell, against sensitivities derived here by another way.

Here the motor is integrated by LSODA and differentiated by central differences; the product uses
matrix exponentials. The rank of the one must be the rank of the other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from motorid.estimate.diagnosis.identifiability import (
    COMBINATIONS,
    TYPICAL,
    Excitation,
    advice,
    assess,
    of_capture,
)
from tests.estimate.partial.truth import Plant, capture, closed_loop, steps

Floats = NDArray[np.float64]
NAMES = ("R", "L", "K", "B", "J", "T0")
# A slow, well-damped motor, unlike the product's: nothing here depends on the preset.
MOTOR = {"R": 1.0, "L": 2e-3, "K": 0.05, "B": 1e-4, "J": 2e-5, "T0": 5e-3}
TIMES = np.linspace(1e-4, 0.15, 150)


def runs(*channels: str, **facts: int | bool) -> Excitation:
    return Excitation(frozenset(channels), **facts)  # type: ignore[arg-type]


def driven(p: dict[str, float], volts: float) -> Floats:
    """(i, ω) at TIMES after the motor breaks away, shape (n, 2)."""

    def slope(_: float, x: Floats) -> list[float]:
        i, w = x
        return [
            (volts - p["R"] * i - p["K"] * w) / p["L"],
            (p["K"] * i - p["B"] * w - p["T0"]) / p["J"],
        ]

    start = [p["T0"] / p["K"], 0.0]
    solution = solve_ivp(
        slope, (0, TIMES[-1]), start, t_eval=TIMES, method="LSODA", rtol=1e-11, atol=1e-13
    )
    return solution.y.T


def speed_from_current(p: dict[str, float], volts: float) -> Floats:
    """ω at TIMES of a motor ``p`` that is driven by the current of MOTOR."""

    def slope(_: float, x: Floats) -> list[float]:
        i, w, moved = x
        m = MOTOR
        return [
            (volts - m["R"] * i - m["K"] * w) / m["L"],
            (m["K"] * i - m["B"] * w - m["T0"]) / m["J"],
            (p["K"] * i - p["B"] * moved - p["T0"]) / p["J"],
        ]

    start = [MOTOR["T0"] / MOTOR["K"], 0.0, 0.0]
    solution = solve_ivp(
        slope, (0, TIMES[-1]), start, t_eval=TIMES, method="LSODA", rtol=1e-11, atol=1e-13
    )
    return solution.y[2]


def coast(p: dict[str, float]) -> Floats:
    """ω while nothing drives the motor, from 200 rad/s, before it stops."""
    solution = solve_ivp(
        lambda _, w: [(-p["B"] * w[0] - p["T0"]) / p["J"]],
        (0, 0.15), [200.0], t_eval=TIMES, method="LSODA", rtol=1e-11, atol=1e-13,
    )  # fmt: skip
    return solution.y[0]


def null_space(readings: Callable[[dict[str, float]], Floats]) -> Floats:
    """Rows: changes of the parameters' logarithms that no reading shows."""
    columns = []
    for name in NAMES:
        up, down = ({**MOTOR, name: MOTOR[name] * (1 + s)} for s in (1e-4, -1e-4))
        columns.append((readings(up) - readings(down)) / 2e-4)
    matrix = np.stack(columns, axis=1)
    values, rows = np.linalg.svd(matrix / np.abs(matrix).max(), full_matrices=True)[1:]
    values = np.pad(values, (0, len(NAMES) - len(values)))
    return rows[values < 1e-6 * values[0]]


def moves(combination: str, null: Floats) -> float:
    """How much a combination changes along the null space, relative to its own gradient."""
    slope = np.array([
        COMBINATIONS[combination]({**MOTOR, n: MOTOR[n] * (1 + 1e-5)})
        - COMBINATIONS[combination]({**MOTOR, n: MOTOR[n] * (1 - 1e-5)})
        for n in NAMES
    ])  # fmt: skip
    return float(np.linalg.norm(null @ slope) / np.linalg.norm(slope))


def levels(
    shown: Callable[[dict[str, float], float], Floats],
) -> Callable[[dict[str, float]], Floats]:
    return lambda p: np.concatenate([shown(p, volts).ravel() for volts in (4.0, 8.0, 12.0)])


SITUATIONS = {
    "everything": (
        runs("current", "terminal_voltage", "speed", coast=False),
        levels(driven),
        0,
        (),
    ),
    "speed only": (
        runs("terminal_voltage", "speed", coast=False),
        levels(lambda p, v: driven(p, v)[:, 1]),
        2,
        ("T0·R/K", "K/(JL)", "R/L+B/J", "(RB+K²)/(JL)"),
    ),
    "current only": (
        runs("terminal_voltage", "current", coast=False),
        levels(lambda p, v: driven(p, v)[:, 0]),
        1,
        ("T0/K", "B/J", "J/K²"),
    ),
    "no voltage": (
        runs("current", "speed", coast=False),
        levels(speed_from_current),
        3,
        ("J/K", "B/K", "T0/K"),
    ),
    "coast only": (runs("speed", levels=0), coast, 4, ("B/J", "T0/J")),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", SITUATIONS)
def test_ranks_and_combinations_agree_with_another_derivation(name: str) -> None:
    run, readings, directions, combinations = SITUATIONS[name]
    null = null_space(readings)
    knowledge = assess(run, MOTOR)
    assert len(null) == directions
    assert knowledge.null_directions == directions
    assert knowledge.combinations == combinations
    for combination in combinations:
        assert moves(combination, null) < 1e-4
    for column, parameter in enumerate(NAMES):
        hidden = np.abs(null[:, column]).max(initial=0.0) > 1e-3
        assert hidden == (parameter in knowledge.missing)


@pytest.mark.slow
def test_current_only_null_direction_is_the_scaling_of_torque() -> None:
    null = null_space(SITUATIONS["current only"][1])[0]
    expected = np.array([0, 0, 1, 2, 2, 1]) / np.sqrt(10)  # K → cK, B → c²B, J → c²J, T0 → cT0
    assert abs(null @ expected) == pytest.approx(1, abs=1e-4)


@pytest.mark.slow
def test_a_combination_that_is_not_known_is_not_claimed() -> None:
    null = null_space(SITUATIONS["speed only"][1])
    for combination in ("J/K", "B/K", "T0/K", "J/K²"):
        assert moves(combination, null) > 1e-2
        assert combination not in assess(SITUATIONS["speed only"][0], MOTOR).combinations


def test_steady_levels_alone_are_singular_without_dry_friction() -> None:
    """V = R i + K ω and K i = B ω + T0: with T0 = 0, i/ω is the same at every level."""
    run = runs("current", "terminal_voltage", "speed", transient=False, coast=False)
    with_friction, without = assess(run, MOTOR), assess(run, {**MOTOR, "T0": 0.0})
    assert with_friction.parameters == ("R", "K", "B", "T0")
    assert {"R", "K", "B"} <= set(without.missing)
    assert {"B/K", "K/(K²+RB)"} == set(without.combinations)
    levels_v = np.array([4.0, 8.0, 12.0])

    def determinant(T0: float) -> float:
        both = np.array([[MOTOR["R"], MOTOR["K"]], [MOTOR["K"], -MOTOR["B"]]])
        i, w = np.linalg.solve(both, np.stack([levels_v, np.full(3, T0)]))
        return float(np.linalg.svd(np.stack([i, w], axis=1))[1][-1])

    assert determinant(0.0) < 1e-12
    assert determinant(MOTOR["T0"]) > 1e-3


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (runs("current", "speed"), ["terminal voltage"]),
        (runs("terminal_voltage", "speed", coast=False), ["current"]),
        (runs("current", "terminal_voltage", coast=False), ["speed or the position"]),
        (
            runs("current", "terminal_voltage", "speed", transient=False, coast=False),
            ["sampled finely"],
        ),
        (runs("speed", levels=0), ["voltage", "current", "levels"]),
    ],
)
def test_the_advised_run_tells_the_rest(run: Excitation, words: list[str]) -> None:
    sentence = advice(run)
    for word in words:
        assert word in sentence
    for missing in assess(run).missing:
        assert missing in sentence


def test_a_complete_run_needs_no_advice() -> None:
    assert advice(runs("current", "terminal_voltage", "speed")) == ""


def test_typical_motor_knows_what_the_data_sheet_motor_knows() -> None:
    for run, *_ in SITUATIONS.values():
        assert assess(run, TYPICAL).null_directions == assess(run, MOTOR).null_directions


def test_a_capture_is_recognised() -> None:
    t, i, w = closed_loop(Plant(), steps(1.0, 0.0, 100.0, 40.0, 160.0), 0.02, 8.0)
    rng = np.random.default_rng(0)
    shown = of_capture(
        capture(
            t,
            current=("A", i + 1e-3 * rng.standard_normal(len(t))),
            speed=("rad/s", w + 0.1 * rng.standard_normal(len(t))),
        )
    )
    assert shown.channels == {"current", "speed"}
    assert shown.levels >= 3
    assert shown.transient
    assert not shown.coast
