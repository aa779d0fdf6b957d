"""What is open of an effect that nobody models: against the whole system of normal equations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.estimate.effects.friction.load_friction import LOAD_FRICTION
from motorid.estimate.effects.iron.saturation import SATURATION
from motorid.estimate.solver.problem import Linearised, Unknown
from motorid.estimate.uncertainty.errors_in_variables import Hidden
from motorid.estimate.uncertainty.undetected import (
    FOUND,
    Undetected,
    _cleared,
    _information,
    _left,
    _mixed,
    _scatter,
    _sums,
    beside,
    told,
)
from tests.estimate.solutions import solution

Floats = NDArray[np.float64]
COUNT = 80


@dataclass(frozen=True)
class System:
    """Derivatives by two shared parameters, by two nuisances with priors, and by an effect."""

    shared: Floats
    own: Floats
    precision: Floats
    column: Floats
    residual: Floats

    @classmethod
    def drawn(cls, size: float, strength: float = 0.3) -> System:
        """Residuals that an effect of that size leaves, as strong as that in a reading."""
        rng = np.random.default_rng(5)
        A, C = rng.standard_normal((COUNT, 2)), rng.standard_normal((COUNT, 2))
        column = strength * (rng.standard_normal(COUNT) + 0.5 * A[:, 0] - 0.4 * C[:, 1])
        noise = 0.05 * rng.standard_normal(COUNT)
        return cls(A, C, np.array([3.0, 0.0]), column, size * column + noise)

    @property
    def line(self) -> Linearised:
        free = self.own.T @ self.own + np.diag(self.precision)
        orthogonal = self.shared - self.own @ np.linalg.solve(free, self.own.T @ self.shared)
        return Linearised(
            self.residual, self.shared, self.own, orthogonal, self.precision, (), (), np.ones(1)
        )

    @property
    def inverse(self) -> Floats:
        return np.asarray(np.linalg.inv(self.shared.T @ self.line.orthogonal))

    def left(self, scatter: float = 1.0) -> Undetected:
        line = self.line
        slope = line.orthogonal.T @ self.residual
        sums = _sums(self.column, line)
        follows = self.inverse @ sums.shared
        information = _information([(0, self.column, line)], [line], follows)
        form = _left((0,), sums, information, self.inverse, slope, scatter)
        return Undetected(LOAD_FRICTION, *_mixed([(1.0, form)]))

    def posterior(self) -> tuple[float, float, Floats]:
        """The effect's size and standard deviation, and what a unit of it moves the parameters."""
        every = np.column_stack([self.shared, self.own, self.column])
        H = every.T @ every + np.diag([0.0, 0.0, *self.precision, 1.0])
        size = float(np.linalg.solve(H, every.T @ self.residual)[-1])
        moves = np.linalg.solve(H[:-1, :-1], every[:, :-1].T @ self.column)[:2]
        return size, float(np.linalg.inv(H)[-1, -1]) ** 0.5, -moves


@pytest.mark.parametrize("size", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("strength", [0.01, 0.3])
def test_what_is_open_is_the_posterior_of_a_unit_prior(size: float, strength: float) -> None:
    system = System.drawn(size, strength)
    found = system.left()
    mean, deviation, moves = system.posterior()
    assert found.open == pytest.approx(deviation)
    seen = mean / deviation if mean / deviation > FOUND else 0.0
    assert found.seen == pytest.approx(seen)
    expected = moves * np.hypot(deviation, 0.0 if seen else max(mean, 0.0))
    assert found.shift == pytest.approx(expected)
    assert found.untold is (deviation > 0.2)


def test_a_size_is_neither_below_nothing_nor_above_that_of_the_prior() -> None:
    below, far = System.drawn(-0.8, 3.0), System.drawn(3.0, 3.0)
    mean, deviation, moves = below.posterior()
    assert mean < -FOUND * deviation
    assert below.left().seen == 0.0
    assert below.left().shift == pytest.approx(moves * deviation)
    mean, deviation, _ = far.posterior()
    assert mean > 2.0
    assert far.left().seen == pytest.approx(1.0 / deviation)


def test_one_that_is_explained_by_the_parameters_is_all_open() -> None:
    system = System.drawn(0.0)
    mixed = system.shared @ [0.3, -0.2] + system.own @ [0.0, 0.7]
    found = System(system.shared, system.own, system.precision, mixed, system.residual).left()
    assert found.open == pytest.approx(1.0, abs=1e-6)
    assert found.shift == pytest.approx([-0.3, 0.2], abs=1e-4)


def test_a_nuisance_that_is_held_takes_nothing() -> None:
    system = System.drawn(0.3)
    held = Linearised(
        system.residual, system.shared, system.own, system.shared, system.precision, (), (),
        np.ones(1), (0, 1),
    )  # fmt: skip
    sums = _sums(system.column, held)
    assert sums.square == pytest.approx(float(system.column @ system.column))
    assert sums.pull == pytest.approx(float(system.column @ system.residual))
    assert sums.shared == pytest.approx(system.shared.T @ system.column)


def test_what_is_left_of_a_change_is_what_parameters_and_nuisances_do_not_explain() -> None:
    system = System.drawn(0.6)
    line, sums = system.line, _sums(system.column, system.line)
    every = np.column_stack([system.shared, system.own])
    H = every.T @ every + np.diag([0.0, 0.0, *system.precision])
    left = system.column - every @ np.linalg.solve(H, every.T @ system.column)
    follows = system.inverse @ sums.shared
    found = _cleared(system.column, line) - line.orthogonal @ follows
    assert found == pytest.approx(left)


def test_an_effect_is_seen_by_as_much_as_its_pull_scatters() -> None:
    """What is open of it stays; a size that is not seen is in the shift."""
    system = System.drawn(0.8, 3.0)
    white, some = system.left(), system.left(2.25)
    assert white.seen > 1.5 * FOUND
    assert some.seen == pytest.approx(white.seen / 1.5)
    assert (some.open, some.shift) == (white.open, pytest.approx(white.shift))
    much = system.left((1.01 * white.seen / FOUND) ** 2)
    mean, deviation, moves = system.posterior()
    assert much.seen == 0.0
    assert much.shift == pytest.approx(moves * np.hypot(deviation, mean))


def test_a_pull_scatters_by_errors_of_the_voltage_too() -> None:
    """By what each changes along the effect, and by those of other records not at all."""
    system = System.drawn(0.0)
    line, c = system.line, _cleared(system.column, system.line)
    rng = np.random.default_rng(8)
    here, there = rng.standard_normal((2, COUNT)), rng.standard_normal(COUNT)
    errors = [Hidden(0, np.zeros(2), np.zeros(2), e) for e in here]
    errors.append(Hidden(1, np.zeros(2), np.zeros(2), there))
    alone = _scatter([(0, system.column, line)], np.zeros(2), ())
    found = _scatter([(0, system.column, line)], np.zeros(2), errors)
    assert found - alone == pytest.approx(float(((here @ c) ** 2).sum() / (c @ c)))
    assert _scatter([(0, 0.0 * system.column, line)], np.zeros(2), errors) == 1.0


def test_a_shift_is_told_as_shares_of_the_parameters_the_largest_first() -> None:
    names = ("R", "L", "B", "T0")
    unknowns = tuple(Unknown(n, 1.0, log=n in ("R", "L")) for n in names)
    values = np.array([2.0, 3.0, 4.0, 0.0])
    answer: Any = type("Answer", (), {"unknowns": unknowns, "values": values})
    shift = np.array([0.1, -0.3, 2.0, 5.0])
    moved = Undetected(LOAD_FRICTION, shift, 1.0).moves(answer)
    assert list(moved) == ["B", "L", "R"]  # T0 is nothing: it has no shares
    assert moved == pytest.approx({"B": 0.5, "L": np.expm1(-0.3), "R": np.expm1(0.1)})
    twice = Undetected(LOAD_FRICTION, shift, 1.0).moves(answer, 2.0)
    assert twice == pytest.approx({"B": 1.0, "L": np.expm1(-0.6), "R": np.expm1(0.2)})
    endless = Undetected(LOAD_FRICTION, 1e4 * shift, 1.0).moves(answer)
    assert endless["R"] == pytest.approx(np.expm1(50.0))
    assert solution().unknowns[0].name == "R"


def test_lines_of_a_budget_are_of_what_the_readings_tell() -> None:
    """Beside an effect that was found, what is seen counts with its size."""
    shift = np.array([1.0, -2.0])

    def one(quantity: Any, left: float, seen: float = 0.0) -> Undetected:
        return Undetected(quantity, shift, left, seen)

    for left, in_told, in_beside in ((0.2, True, True), (0.21, False, True), (0.51, False, False)):
        found = [one(LOAD_FRICTION, left)]
        assert (set(told(found)) == {LOAD_FRICTION.name}) is in_told
        assert (set(beside(found)) == {LOAD_FRICTION.name}) is in_beside
    both = [one(LOAD_FRICTION, 0.05, seen=5.0), one(SATURATION, 0.05)]
    assert set(told(both)) == {SATURATION.name}
    assert told(both)[SATURATION.name] is shift
    more = beside(both)
    assert more[LOAD_FRICTION.name] == pytest.approx(shift * 26.0**0.5)
    assert more[SATURATION.name] == pytest.approx(shift)


def test_one_that_is_kept_has_its_line_whatever_the_readings_tell() -> None:
    """But one that is seen: the search says what it is."""
    found = Undetected(LOAD_FRICTION, np.array([1.0, -2.0]), 0.9, kept=True)
    assert not found.untold
    assert set(told([found])) == set(beside([found])) == {LOAD_FRICTION.name}
    seen = replace(found, seen=5.0)
    assert seen.untold
    assert told([seen]) == {}
