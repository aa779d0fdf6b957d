"""A fault's size as one more unknown, and what a fault does, on records that are linear."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture.model import CURRENT, SPEED
from motorid.errors import DataError
from motorid.estimate.diagnosis import fault, misfit, rank, refit
from motorid.estimate.diagnosis.fault import Hypothesis
from motorid.estimate.diagnosis.refit import Widened
from motorid.estimate.effects.reading.current_offset import CURRENT_OFFSET
from motorid.estimate.signals.measurements import EMF
from motorid.estimate.solver.problem import Unknown
from tests.estimate.solutions import MOTOR, solution

RNG = np.random.default_rng(8)
GAINS = RNG.standard_normal((5, 4))  # of five readings by four volts
VOLTS = np.array([0.0, 6.0, -9.0, 3.0])


def record(**facts: Any) -> Any:
    """Readings are linear in the volts, and quadratic beyond, by a little."""

    def fitted_with(values: Any, own: Any, volts: Any) -> list[Any]:
        y = GAINS @ volts + 0.1 * (GAINS @ volts) ** 2
        return [y[:3], y[3:]]

    def fitted(values: Any, own: Any, more: Any = None) -> list[Any]:
        y = fitted_with(values, own, VOLTS)
        for one, size in (more or {}).items():
            assert one.quantity is CURRENT_OFFSET
            y = [y[0] + size**2, y[1]]
        return y

    given = {
        "fitted": fitted, "fitted_with": fitted_with, "volts": VOLTS, "simulated": 7,
        "weighed": lambda parts, filtered: [(2.0 * p, filtered) for p in parts],
        "departures": lambda shared, own: [np.full(2, shared.sum()), np.full(3, own.sum())],
        "unknowns": (Unknown("offset", 0.0, prior_sd=0.5), Unknown("lag", 1.0)),
        "measured": [SimpleNamespace(block="current block", values=np.zeros(3)),
                     SimpleNamespace(block="speed block", values=np.zeros(2))],
    }  # fmt: skip
    return SimpleNamespace(**{**given, **facts})


def hypothesis(**facts: Any) -> Hypothesis:
    """Two numbers: the first in the current, the second in the speed."""

    def effect(of: Any, values: Any, own: Any, size: Any) -> list[Any]:
        assert list(values) == [1.0, 2.0]
        return [size[0] * np.ones(2), size[1] * np.ones(3)]

    given = {
        "code": "late", "effect": effect, "sizes": ((1.0, 1.0),), "scale": (1e-3, 2.0),
        "lower": (-1.0, 0.0), "upper": (4.0, 5.0), "words": None,
    }  # fmt: skip
    return Hypothesis(**{**given, **facts})


def test_what_a_fault_does_is_taken_from_what_is_left() -> None:
    """Measured less fitted less the fault, weighed, its noise white."""
    own = np.array([0.25, 0.5])
    wide = Widened(record(), own, hypothesis())
    assert wide.simulated == 7
    assert wide.blocks == ("current block", "speed block")
    assert [(u.name, u.start, u.prior_sd) for u in wide.unknowns] == [
        ("offset", 0.25, 0.5), ("lag", 0.5, np.inf),
    ]  # fmt: skip
    found = wide.residuals(np.array([1.0, 2.0, 0.3, 0.1]), np.array([7.0, 1.0]))
    (current, one), (speed, other) = found
    assert current == pytest.approx([2.0 * 2.7] * 2)
    assert speed == pytest.approx([2.0 * 7.9] * 3)
    assert (one, other) == (False, False)
    (plain, white), _ = Widened(record(), own, None).residuals(np.array([1.0, 2.0]), own)
    assert plain == pytest.approx([6.0] * 2)
    assert white is False


class Searched:
    """Searches that end with these objectives, and what was asked of them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *objectives: float) -> None:
        self.left, self.asked = list(objectives), list[Any]()
        monkeypatch.setattr(refit, "maximise", self.search)

    def search(self, unknowns: Any, records: Any, **how: Any) -> Any:
        self.asked.append((unknowns, records, how))
        values = np.arange(len(unknowns)) + 10.0 * len(self.asked)
        own = (np.array([0.5 * len(self.asked), 7.0]),)
        objective = self.left.pop(0)
        if math.isinf(objective):
            raise DataError("no motor")
        return SimpleNamespace(values=values, objective=objective, own=own)


def test_a_start_without_finite_readings_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fault may lead there; the fit of the captures goes on. Without a fault nothing is left."""
    searched = Searched(monkeypatch, math.inf, 3.0, math.inf, math.inf)
    starts = [solution(), solution(R=3.0)]
    for start in starts:
        object.__setattr__(start, "own", (np.array([0.25, 0.5]),))
    assert refit.refit([record()], starts, hypothesis(), (0.7, 0.8)).objective == 3.0
    lost = refit.refit([record()], starts[:1], hypothesis(), (0.7, 0.8))
    assert math.isinf(lost.objective)
    assert (list(lost.values), list(lost.size)) == (list(starts[0].values), [0.7, 0.8])
    with pytest.raises(DataError, match="no motor with finite"):
        refit.refit([record()], starts[:1])
    assert len(searched.asked) == 4


def test_a_trial_begins_at_each_start_and_the_likeliest_counts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    searched = Searched(monkeypatch, 5.0, 3.0, 4.0)
    starts = [solution(), solution(R=3.0), solution()]
    for start in starts:
        object.__setattr__(start, "own", (np.array([0.25, 0.5]),))
    found = refit.refit([record()], starts, hypothesis(), (0.7, 0.8), 0.3)
    assert found.objective == 3.0
    assert list(found.values) == [20.0 + k for k in range(6)]
    assert list(found.size) == [26.0, 27.0]
    unknowns, (wide,), how = searched.asked[1]
    assert [u.start for u in unknowns[:6]] == [3.0, *list(MOTOR.values())[1:]]
    sizes = [(u.start, u.lower, u.upper, u.scale, u.log) for u in unknowns[6:]]
    assert sizes == [(0.7, -1.0, 4.0, 1e-3, False), (0.8, 0.0, 5.0, 2.0, False)]
    assert how == {"max_iterations": 20, "enough": 0.3}
    assert wide.hypothesis is not None
    assert [u.start for u in wide.unknowns] == [0.25, 0.5]


def test_a_fault_in_whole_samples_begins_at_every_size_and_the_better_ones_go_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """From two starts: (1, 1), of the screen, then (2, 1); few steps each, and the best two on."""
    searched = Searched(monkeypatch, 9.0, 7.0, 8.0, 6.0, 5.5, 5.0)
    starts = [solution(), solution(R=3.0)]
    for start in starts:
        object.__setattr__(start, "own", (np.array([0.25, 0.5]),))
    stepwise = hypothesis(sizes=((1.0, 1.0), (2.0, 1.0)), stepwise=True)
    usual: Any = SimpleNamespace(objective=7.5)
    found = rank._ended([record()], starts, stepwise, (1.0, 1.0), 0.3, usual)
    assert found.objective == 5.0
    begun, ended = searched.asked[:4], searched.asked[4:]
    sizes = [tuple(u.start for u in unknowns[6:]) for unknowns, _, _ in begun]
    assert sizes == [(1.0, 1.0), (1.0, 1.0), (2.0, 1.0), (2.0, 1.0)]
    assert {how["max_iterations"] for _, _, how in begun} == {rank.FEW}
    assert {how["max_iterations"] for _, _, how in ended} == {20}
    # where the fourth search and the second were, nuisances and all
    for (unknowns, (wide,), _), place in zip(ended, (4, 2), strict=True):
        assert [u.start for u in unknowns] == [10.0 * place + k for k in range(8)]
        assert [u.start for u in wide.unknowns] == [0.5 * place, 7.0]


@pytest.mark.parametrize(("usual", "ended"), [(6.5, 1), (5.5, 0)])
def test_what_is_worse_than_no_fault_goes_on_no_more(
    usual: float, ended: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    searched = Searched(monkeypatch, 9.0, 7.0, 6.0, 5.0)
    start = solution()
    object.__setattr__(start, "own", (np.array([0.25, 0.5]),))
    stepwise = hypothesis(sizes=((1.0, 1.0), (2.0, 1.0), (3.0, 1.0)), stepwise=True)
    without: Any = SimpleNamespace(objective=usual)
    found = rank._ended([record()], [start], stepwise, (1.0, 1.0), 0.3, without)
    assert len(searched.asked) == 3 + ended
    assert found.objective == (5.0 if ended else 6.0)


def test_without_a_fault_a_trial_is_of_the_motor_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    searched = Searched(monkeypatch, 5.0)
    found = refit.refit([], [solution()])
    assert (len(found.values), len(found.size)) == (6, 0)
    assert searched.asked[0][2]["enough"] == 1.0
    assert found.search.objective == 5.0


def test_derivatives_in_white_noise_are_taken_where_the_fit_ended(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """No step is made; what cannot be below nothing and is above it moves by its logarithm."""
    searched = Searched(monkeypatch, 5.0)
    here = solution(B=0.0)
    unknowns = tuple(
        Unknown(u.name, 9.0, -np.inf if u.name == "L" else 0.0, log=u.name == "R")
        for u in here.unknowns
    )
    object.__setattr__(here, "unknowns", unknowns)
    object.__setattr__(here, "own", (np.array([0.25, 0.5]),))
    refit.plain([record()], here)
    ((asked, (wide,), how),) = searched.asked
    assert [u.start for u in asked] == list(here.values)
    assert [u.name for u in asked if u.log] == ["R", "K", "J", "T0"]
    assert how == {"max_iterations": 0}
    assert wide.hypothesis is None


def test_a_hypothesis_is_a_fault_unless_it_is_said_to_be_none() -> None:
    plain = hypothesis()
    assert (plain.guard, plain.quantity, plain.remedy) == (False, None, None)


# ---------------------------------------------------------------- what a fault does to the readings


def test_a_quantity_acts_by_its_size() -> None:
    change = fault.acting(CURRENT_OFFSET)(record(), np.zeros(1), np.zeros(1), np.array([3.0, 8.0]))
    assert change[0] == pytest.approx([9.0] * 3)
    assert change[1] == pytest.approx([0.0] * 2)
    assert [list(part) for part in fault.nothing(record())] == [[0.0] * 3, [0.0] * 2]


def test_another_voltage_is_exact_and_an_added_one_to_first_order() -> None:
    none = np.zeros(1)
    added = np.array([0.0, 2.0, 1.0, -4.0])
    usual = GAINS @ VOLTS
    exact = GAINS @ added + 0.1 * ((GAINS @ (VOLTS + added)) ** 2 - usual**2)
    changed = np.concatenate(fault.changed_voltage(record(), none, none, VOLTS + added))
    assert changed == pytest.approx(exact)
    first = (1.0 + 0.2 * usual) * (GAINS @ added)
    found = np.concatenate(fault.added_voltage(record(), none, none, added))
    assert found == pytest.approx(first, rel=5e-3)
    assert not np.allclose(found, exact, rtol=0.02)
    # at most as it is: what is tiny beside the volts is not made larger
    tiny = 1e-5 * added
    small = np.concatenate(fault.added_voltage(record(), none, none, tiny))
    assert small == pytest.approx(1e-5 * first, rel=1e-3)
    assert [len(part) for part in fault.added_voltage(record(), none, none, 0.0 * added)] == [3, 2]


def test_responses_are_of_channels_with_a_sign_and_in_their_unit() -> None:
    """A back-EMF is K times the speed that the motor answers with."""
    rows = np.array([[1.0, 2.0], [3.0, 4.0]])
    measured = [
        SimpleNamespace(block=SimpleNamespace(name=CURRENT), unsigned=False, row=0),
        SimpleNamespace(block=SimpleNamespace(name=SPEED), unsigned=True, row=1),
        SimpleNamespace(block=SimpleNamespace(name=EMF), unsigned=False, row=1),
    ]
    one = record(measured=measured, readings=lambda *_: rows, emf_constant=lambda _: 0.05)
    none = np.zeros(1)
    found = list(fault.series(one, none, none, CURRENT, SPEED, EMF))
    assert [k for k, _ in found] == [0, 2]
    assert found[0][1] == pytest.approx([1.0, 2.0])
    assert found[1][1] == pytest.approx([0.15, 0.2])
    assert fault.current_of(one, none, none) == pytest.approx([1.0, 2.0])
    bare = record(measured=measured[1:], readings=lambda *_: rows, emf_constant=lambda _: 0.05)
    assert fault.current_of(bare, none, none) is None


def test_a_fault_with_a_place_is_fitted_there(monkeypatch: pytest.MonkeyPatch) -> None:
    searched, start = Searched(monkeypatch, 3.0), solution()
    object.__setattr__(start, "own", (np.array([0.25, 0.5]),))
    refit.refit([record()], [start], hypothesis(place=lambda size: 7), (0.7, 0.8))
    ((unknowns, _, _),) = searched.asked
    assert [(u.start, u.lower, u.upper) for u in unknowns[-2:]] == [(0.7, -1.0, 4.0), (0.8,) * 3]


def test_what_chance_gives_a_fault_is_told_from_what_it_leaves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    search: Any = SimpleNamespace(own=[np.zeros(1)])
    found = refit.Refit(np.zeros(2), np.array([0.1]), 5.0, search)
    given: list[Any] = []

    def excess(_: Any, of: Any, more: Any = ()) -> float:
        given.append(more)
        return 0.2 if more else 0.9

    monkeypatch.setattr(refit, "residuals", lambda *_: "left")
    monkeypatch.setattr(misfit, "excess", excess)
    one: Any = SimpleNamespace(measured=[SimpleNamespace(root_weights=np.array([1.0, 2.0]))])
    chance = hypothesis(scatter=lambda *_: [np.array([3.0, 1.0])])
    assert refit.rest([one], found, chance) == pytest.approx((0.2, 0.7))
    assert given[0] == [[3.5]]  # by weights: (3 + 4 · 1) / 2
    assert refit.rest([one], found, hypothesis()) == (0.9, 0.0)
    nowhere = refit.Refit(np.zeros(2), np.array([0.1]), math.inf, found.search)
    assert refit.rest([one], nowhere, chance) == (math.inf, 0.0)


@pytest.mark.parametrize("best", [3, 20, 41, 63])
@pytest.mark.parametrize("begun", [0, 24, 63])
def test_a_place_is_where_a_fit_explains_most(
    begun: int, best: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Derivatives chose another; the fit goes on from the best with its share, in few fits."""
    rates = [float(k) for k in range(100, 164)]
    placed = SimpleNamespace(sizes=[(0.01, r) for r in rates], place=lambda size: 0, stepwise=False)
    fits: list[float] = []

    def fitted(records: Any, starts: Any, h: Any, size: Any, enough: float, *_: int) -> Any:
        fits.append(size[1])
        search = SimpleNamespace(own=())
        left = abs(size[1] - rates[best])
        return refit.Refit(np.ones(6), np.array([0.03, size[1]]), left, search)  # type: ignore[arg-type]

    monkeypatch.setattr(rank, "refit", fitted)
    monkeypatch.setattr(rank, "go_on", lambda _, near, h, found, enough: found)
    usual = refit.Refit(np.ones(6), np.zeros(0), 1e3, SimpleNamespace())  # type: ignore[arg-type]
    starts = [solution()]
    found = rank._ended([], starts, placed, (0.01, rates[begun]), 1.0, usual)  # type: ignore[arg-type]
    reach = sum(rank.STRIDES)
    assert abs(found.size[1] - rates[best]) <= max(abs(best - begun) - reach, 0)
    assert len(fits) <= 1 + 2 * len(rank.STRIDES)
    worse = refit.Refit(np.ones(6), np.zeros(0), -1.0, SimpleNamespace())  # type: ignore[arg-type]
    fits.clear()
    rank._ended([], starts, placed, (0.01, rates[begun]), 1.0, worse)  # type: ignore[arg-type]
    assert fits == [rates[begun]]  # no place of a fault that explains nothing is sought
