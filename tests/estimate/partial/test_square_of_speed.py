"""A fan on the shaft of a log with a channel missing, by an integration of its own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from motorid.capture.model import CURRENT, SPEED, VOLTAGE, Capture, Channel
from motorid.estimate.partial import square_of_speed as module
from motorid.estimate.partial.block_bootstrap_regression import solve
from motorid.estimate.partial.mechanical_fit import fit
from motorid.estimate.partial.modulating_functions import SQUARE, Rows
from motorid.estimate.results.estimate import Estimate
from motorid.estimate.results.status import Status
from tests.report.example import estimate, parameter

Floats = NDArray[np.float64]
R, K, B, J, T0, VOLTS = 2.0, 0.05, 2e-5, 4e-5, 5e-3, 24.0
TOP = VOLTS / K
FAN = 0.06 * K * VOLTS / R / TOP**2  # 6 % of the stall torque at the top speed
PERIOD_S, ROWS_A_LEVEL = 1.6e-3, 80
LEVELS = (0.4, 0.9, 0.6, 1.0, 0.3, 0.8, 0.5, 0.95, 0.7, 0.35)
CLEAR = K**2 + R * B
TRUTH = {
    "JR/(K²+RB)": J * R / CLEAR, "K/(K²+RB)": K / CLEAR, "T0·R/K": T0 * R / K,
    "J/K": J / K, "B/K": B / K, "T0/K": T0 / K,
}  # fmt: skip


def turned(fan: float) -> tuple[Floats, Floats, Floats]:
    """Volts, current and speed at the rows; levels change between two of them."""
    stamps = PERIOD_S * (np.arange(ROWS_A_LEVEL) + 0.5)
    speed, volts, speeds = 0.01, [], []
    for level in LEVELS:

        def slope(_: float, w: Floats, v: float = level * VOLTS) -> Floats:
            return np.asarray((K * (v - K * w) / R - B * w - fan * w**2 - T0) / J)

        end = PERIOD_S * ROWS_A_LEVEL
        found = solve_ivp(slope, (0, end), [speed], t_eval=[*stamps, end], rtol=1e-9, atol=1e-9)
        speeds.append(found.y[0, :-1])
        volts.append(np.full(ROWS_A_LEVEL, level * VOLTS))
        speed = float(found.y[0, -1])
    v, w = np.concatenate(volts), np.concatenate(speeds)
    return v, (v - K * w) / R, w


def logged(fan: float, drive: str) -> Capture:
    rng = np.random.default_rng(5)
    v, i, w = turned(fan)
    read = {VOLTAGE: ("V", v, 0.01), CURRENT: ("A", i, 0.01), SPEED: ("rad/s", w, 0.3)}
    channels = {
        name: replace(Channel(name, unit, values + rng.normal(0.0, sigma, len(values))),
                      undeclared=frozenset({"delay"}))
        for name, (unit, values, sigma) in read.items() if name in (drive, SPEED)
    }  # fmt: skip
    ticks = np.rint(1e9 * PERIOD_S * np.arange(len(v))).astype(np.int64)
    return Capture(ticks, 1e9, channels)


def told(found: Estimate) -> dict[str, Any]:
    return {name: p for name, p in found.combinations.items() if p.value is not None}


@pytest.mark.slow
@pytest.mark.parametrize("drive", [VOLTAGE, CURRENT])
def test_a_fan_is_named_once_and_what_it_moves_is_doubtful(drive: str) -> None:
    found = fit([logged(FAN, drive)])
    (named,) = [one for one in found.diagnostics if one.code == "better_model"]
    assert named.severity == "warning"
    assert "square of speed" in named.message
    known = told(found)
    assert any(p.status is Status.DOUBTFUL for p in known.values())
    for name, p in known.items():
        low, high = p.interval_95
        assert low <= TRUTH[name] <= high, name
        assert (p.status is Status.DOUBTFUL) or name not in named.moves


@pytest.mark.slow
@pytest.mark.parametrize("drive", [VOLTAGE, CURRENT])
def test_no_fan_is_seen_where_there_is_none(drive: str) -> None:
    found = fit([logged(0.0, drive)])
    assert not {"better_model", "lack_of_fit"} & {one.code for one in found.diagnostics}
    for name, p in told(found).items():
        low, high = p.interval_95
        assert low <= TRUTH[name] <= high, name
        assert p.status is not Status.DOUBTFUL


# by rows of a known balance

COEFFICIENTS = np.array([0.02, 0.05, 0.3, 0.01])


def rows(square: float, noise: float) -> Rows:
    rng = np.random.default_rng(7)
    n = 96
    matrix, shapes = rng.standard_normal((n, 4)), rng.standard_normal((n, 3))
    drive = matrix @ COEFFICIENTS + square * shapes[:, 0] + noise * rng.standard_normal(n)
    ones = np.ones(n)
    return Rows(matrix, drive, ones, ones, np.arange(n) // 8, np.zeros(n, int), shapes, ones)


def looked_for(square: float, noise: float, drive: str = CURRENT) -> module.Square:
    given = rows(square, noise)
    best = solve(given, np.ones(4, bool), np.zeros(4), 0.1)
    wide = solve(given.beside(SQUARE), np.ones(5, bool), np.zeros(5), 0.1)
    return module.looked_for(drive, best, lambda terms: wide if terms == (SQUARE,) else None)


def test_a_size_that_stands_out_is_found_and_one_that_drives_is_not() -> None:
    found = looked_for(0.05, 0.01)
    assert found.wider is not None
    assert found.wider.coefficients[4] == pytest.approx(0.05, abs=0.01)
    assert found.moves == ()
    assert looked_for(-0.05, 0.01).wider is None


def test_what_may_be_there_is_left_open() -> None:
    noisy = looked_for(0.0, 1.0, VOLTAGE)  # rows say nothing: as it usually is
    assert noisy.wider is None
    (moves,) = noisy.moves
    assert np.abs(moves).max() > 0.0
    quiet = looked_for(0.0, 1e-6)
    assert np.abs(quiet.moves[0]).max() < 1e-5
    assert module.looked_for(CURRENT, solve(rows(0, 1), np.ones(4, bool), np.zeros(4), 0.1),
                             lambda _: None) == module.Square(None)  # fmt: skip


def test_of_volts_dry_friction_says_what_is_usual() -> None:
    best = solve(rows(0.0, 1e-9), np.ones(4, bool), np.zeros(4), 0.1)
    assert module._friction(CURRENT, best) == pytest.approx(0.05)
    top = np.abs(best.rows.matrix[:, 1]).max()
    assert module._friction(VOLTAGE, best) == pytest.approx(0.3 / top)
    braked = replace(best, coefficients=-best.coefficients)
    assert module._friction(CURRENT, braked) == module._friction(VOLTAGE, braked) == 0.0


def test_values_that_a_wider_balance_does_not_know_may_be_anything() -> None:
    plain = replace(estimate(), combinations={"J/K": parameter("J/K", "kg", 2.0),
                                              "B/K": parameter("B/K", "kg", 5.0)})  # fmt: skip
    unknown = replace(parameter("J/K", "kg", 2.0), value=None, total=None, interval_95=None)
    wider = replace(plain, combinations={**plain.combinations, "J/K": unknown})
    found = module.named(plain, wider, "current")
    said = found.diagnostics[0]
    assert (said.code, said.moves, said.sides) == ("better_model", {"J/K": math.inf}, {})
    assert found.combinations["J/K"].status is Status.DOUBTFUL
    assert found.combinations["B/K"] == plain.combinations["B/K"]
    assert module.named(plain, plain, "current") is plain
