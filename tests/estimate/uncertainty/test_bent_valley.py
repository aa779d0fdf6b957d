"""What follows an inductance that is hardly told by no straight line: on likelihoods, and valleys
in them, that are given.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.errors import DataError
from motorid.estimate.solver.problem import Solution, Unknown
from motorid.estimate.uncertainty import bent_valley, profile_likelihood
from motorid.estimate.uncertainty.covariance import NOISE, Statistical
from motorid.estimate.uncertainty.intervals import NORMAL_95
from tests.estimate.made_findings import RELATIVE, VALUES, findings

Floats = NDArray[np.float64]

BASE = 40.0  # objective of the best
SD = 0.4  # of ln L
REACH = NORMAL_95 * SD  # of an end
PLACES = {name: k for k, name in enumerate(VALUES)}
RECORDS: Any = ("run",)


@dataclass
class Valley:
    """A search whose objective is a parabola of ln L, and whose other values follow it.

    ``follows``: by how much each moves, in search coordinates, where ln L has moved by so much.
    ``fails``: whether no motor remains there. ``noise``: of the objective there.
    """

    solution: Solution
    follows: Mapping[str, Callable[[float], float]]
    fails: Callable[[float], bool]
    noise: Callable[[float], float]
    steep: float = 1.0  # times the objective of white noise
    asked: list[float] = field(default_factory=list)

    def away(self, found: Solution) -> float:
        return math.log(found.values[PLACES["L"]] / VALUES["L"])

    def search(self, held: Sequence[Unknown], records: Any, before: Solution) -> Solution:
        assert before is self.solution
        assert records is RECORDS
        (k,) = [k for k, u in enumerate(held) if u.lower == u.upper]
        assert held[k].name == "L"
        away = math.log(held[k].start / VALUES["L"])
        self.asked.append(away)
        if self.fails(away):
            raise DataError("no motor")
        values = before.values.copy()
        values[k] = held[k].start
        for name, curve in self.follows.items():
            place = PLACES[name]
            moved, log = curve(away), before.unknowns[place].log
            values[place] = values[place] * math.exp(moved) if log else values[place] + moved
        white = np.linalg.inv(before.information)[k, k]
        objective = BASE + self.steep * away**2 / white + self.noise(away)
        return replace(before, values=values, objective=objective)

    def judged(self, records: Any, found: Solution) -> Solution:
        assert records is RECORDS
        return replace(found, noise=self.noise(self.away(found)))


def bent(
    monkeypatch: pytest.MonkeyPatch, sd: float = SD, noise: Callable[[float], float] | None = None,
    fails: Callable[[float], bool] = lambda _: False, freedom: float = np.inf, wider: float = 1.0,
    correlation: Mapping[tuple[str, str], float] | None = None, bound: tuple[str, ...] = (),
    steep: float = 1.0, **follows: Callable[[float], float],
) -> tuple[list[Floats], Valley]:  # fmt: skip
    """Shifts; ``wider``: times the deviation of white noise, that a coloured one leaves of all."""
    found = findings({**RELATIVE, "L": sd}, freedom=freedom, correlation=correlation, bound=bound)
    noise = noise or (lambda _: 0.0)
    before = replace(found.solution, objective=BASE + noise(0.0))
    valley = Valley(before, follows, fails, noise, steep)
    monkeypatch.setattr(profile_likelihood, "maximise", valley.search)
    monkeypatch.setattr(bent_valley.added_noise, "judged", valley.judged)
    covariance = wider**2 * found.statistical.covariance
    known = Statistical(
        covariance, found.statistical.freedom, 1.0, False, {NOISE: np.diag(covariance).copy()}
    )
    return bent_valley.shifts(before, RECORDS, known), valley


def moved(shift: Floats) -> dict[str, float]:
    return {name: float(shift[k]) for name, k in PLACES.items() if shift[k] != 0.0}


def below(size: float) -> Callable[[float], float]:
    """It moves so far at the lower end, and stays at the upper one."""
    return lambda away: size * away / -REACH if away < 0.0 else 0.0


# which are bent


@pytest.mark.parametrize(("sd", "count"), [(0.99, 0), (1.01, 1)])
def test_an_inductance_that_is_told_has_no_bend(
    sd: float, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, valley = bent(monkeypatch, sd * bent_valley.BENT["L"], J=below(0.5))
    assert len(found) == count
    assert bool(valley.asked) is bool(count)  # no search for what is told


def test_no_other_parameter_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(profile_likelihood, "maximise", lambda *_, **__: pytest.fail("searched"))
    vague = findings({**dict.fromkeys(VALUES, 2.0), "L": 0.1})
    assert bent_valley.shifts(vague.solution, RECORDS, vague.statistical) == []


def test_an_inductance_that_is_searched_by_differences_has_none(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its deviation is no share of it."""
    monkeypatch.setattr(profile_likelihood, "maximise", lambda *_, **__: pytest.fail("searched"))
    vague = findings({**RELATIVE, "L": 2.0})
    unknowns = tuple(replace(unknown, log=False) for unknown in vague.solution.unknowns)
    by_differences = replace(vague.solution, unknowns=unknowns)
    assert bent_valley.shifts(by_differences, RECORDS, vague.statistical) == []


def test_what_follows_by_a_straight_line_has_its_part_already(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An inertia that follows by what the covariance says of it, or by less."""
    rho = 0.9
    slope = rho * RELATIVE["J"] / SD
    for share, most in ((1.0, 1e-6), (0.9, 0.0)):
        found, _ = bent(
            monkeypatch, correlation={("L", "J"): rho}, J=lambda x, share=share: share * slope * x
        )
        assert max((np.abs(one).max() for one in found), default=0.0) <= most


# how far


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("rho", [0.0, 0.9, -0.9])
def test_a_shift_is_what_moved_less_what_a_straight_line_foretells(
    rho: float, sign: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In squares, for one standard deviation of the inductance, which itself is left out."""
    (shift,), valley = bent(
        monkeypatch, correlation={("L", "J"): rho}, J=below(sign * 0.3), B=below(sign * 4e-5)
    )
    assert valley.asked == pytest.approx([-REACH, -REACH, REACH, REACH])  # a parabola's ends
    one, straight = 0.3 / NORMAL_95, rho * RELATIVE["J"]
    assert set(moved(shift)) == {"J", "B"}
    assert moved(shift)["J"] == pytest.approx(sign * math.sqrt(one**2 - straight**2))
    assert moved(shift)["B"] == pytest.approx(sign * 4e-5 / NORMAL_95)


@pytest.mark.parametrize(("lower", "upper"), [(0.3, 0.2), (0.2, 0.3)])
def test_the_end_counts_at_which_more_moves_by_standard_deviations(
    lower: float, upper: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of J there, and of K, which is told four times as well, so much less."""
    finer = RELATIVE["K"] / RELATIVE["J"]
    (shift,), _ = bent(
        monkeypatch, J=below(lower), K=lambda x: upper * finer * x / REACH if x > 0.0 else 0.0
    )
    expected = {"J": lower} if lower > upper else {"K": upper * finer}
    assert moved(shift) == pytest.approx({n: v / NORMAL_95 for n, v in expected.items()})


def test_an_end_without_a_motor_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """The other one counts; without either there is no shift."""
    how: dict[str, Any] = {"J": lambda x: 0.3 * x / REACH if x > 0.0 else 0.0, "K": below(0.3)}
    (shift,), _ = bent(monkeypatch, fails=lambda x: x < 0.0, **how)
    assert moved(shift) == pytest.approx({"J": 0.3 / NORMAL_95})
    (shift,), _ = bent(monkeypatch, fails=lambda x: x > 0.0, **how)
    assert moved(shift) == pytest.approx({"K": 0.3 / NORMAL_95})
    found, _ = bent(monkeypatch, fails=lambda _: True, **how)
    assert found == []


def test_friction_that_is_nothing_follows_by_differences(monkeypatch: pytest.MonkeyPatch) -> None:
    """It has no ratio."""
    with np.errstate(all="raise"):
        (shift,), _ = bent(monkeypatch, bound=("B",), B=below(4e-5))
    assert moved(shift) == pytest.approx({"B": 4e-5 / NORMAL_95})


# where the ends are


def test_ends_are_students_for_few_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """And what moves is divided by the same factor."""
    student = 2.77645  # of 4 degrees of freedom
    (shift,), valley = bent(monkeypatch, freedom=4.0, J=below(0.3))
    assert valley.asked[0] == pytest.approx(-student * SD)
    assert moved(shift)["J"] == pytest.approx(0.3 * valley.asked[0] / -REACH / student)


@pytest.mark.parametrize("wider", [2.0, 0.5])
def test_a_wider_covariance_has_the_likelihood_fall_farther(
    wider: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By as much as its noise is more than white, and no less than by white noise's."""
    (shift,), valley = bent(monkeypatch, sd=0.7, wider=wider, J=below(0.2))
    reach = max(wider, 1.0) * NORMAL_95 * 0.7
    assert valley.asked == pytest.approx([-reach, -reach, reach, reach])
    assert moved(shift) == pytest.approx({"J": 0.2 * reach / REACH / NORMAL_95})


def test_causes_beside_the_noise_move_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are no fall of the likelihood; by them too an inductance may be hardly told."""
    valley = bent(monkeypatch)[1]
    known = findings({**RELATIVE, "L": SD}).statistical
    more = known.covariance.copy()
    more[PLACES["L"], PLACES["L"]] *= 9.0
    wide = replace(known, covariance=more)
    valley.asked.clear()
    bent_valley.shifts(valley.solution, RECORDS, wide)
    assert valley.asked == pytest.approx([-REACH, -REACH, REACH, REACH])


def test_no_inductance_is_held_below_one_that_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the likelihood falls nowhere: as far as an end is looked for at first, and twice."""
    _, valley = bent(monkeypatch, sd=2.0, steep=0.0)
    least = bent_valley.FARTHEST * bent_valley.NEAREST
    assert valley.asked[0] == pytest.approx(-bent_valley.FARTHEST)
    assert min(valley.asked) == pytest.approx(-least)
    upper = [away for away in valley.asked if away > 0.0]
    assert upper[0] == pytest.approx(bent_valley.FARTHEST)


def test_the_likelihood_falls_by_what_is_not_the_voltages_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Noise that a small inductance passes says nothing against it; nor what all are left."""
    told = bent(monkeypatch, noise=lambda away: 7.0 - 5.0 * away, J=below(0.3))
    plain = bent(monkeypatch, J=below(0.3))
    assert told[1].asked == pytest.approx(plain[1].asked)
    assert moved(told[0][0]) == pytest.approx(moved(plain[0][0]))
