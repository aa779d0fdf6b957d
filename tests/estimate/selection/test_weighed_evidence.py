"""What a wider fit is weighed by: prices, sizes at a known shape, and the narrower fit in it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.estimate.model.extended_terms import TERMS
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.selection import evidence as module
from motorid.estimate.selection.evidence import Evidence, Price, deviation_at, in_order, shapes_of
from motorid.estimate.selection.extended_fit import Fitted, begin
from motorid.estimate.solver.problem import Solution
from motorid.estimate.uncertainty.covariance import statistical
from tests.estimate.effects.benches import FAULHABER
from tests.estimate.uncertainty.test_budget import fitted

LOAD = TERMS["quadratic-load"]


def price(paid: float, unknowns: int = 1, open_: float = 10.0) -> Price:
    return Price(paid, unknowns, open_)


def test_the_cheapest_is_first_and_of_those_that_are_alike_the_simplest() -> None:
    assert in_order([price(30.0), price(10.0, 3), price(19.9, 2), price(20.0)]) == [2, 1, 3, 0]
    assert in_order([price(12.0, 2), price(11.0, 2), price(10.0, 2)]) == [2, 1, 0]
    assert in_order([price(50.0, 1), price(40.0, 9), price(10.0, 5)]) == [2, 1, 0]
    assert in_order([price(10.0, 2, 1.0), price(10.9, 1), price(11.0, 0)]) == [1, 0, 2]
    assert in_order([]) == []


@pytest.mark.parametrize(
    ("facts", "suffices", "supports"),
    [
        ({}, True, True), ({"gain": 40.0}, False, False), ({"gain": 40.1}, True, True),
        ({"size": 4.0}, True, False), ({"left_out": 0.0}, True, False),
        ({"left_out": 1e-9}, True, True),
    ],
)  # fmt: skip
def test_evidence_is_beyond_each_of_its_bounds(
    facts: dict[str, float], suffices: bool, supports: bool
) -> None:
    found = Evidence(**{"gain": 60.0, "inflation": 2.0, "needed": 20.0, "size": 5.0, **facts})
    assert (found.suffices, found.supports) == (suffices, supports)


@pytest.mark.parametrize("held", [[], [2], [0, 3]])
def test_a_deviation_where_others_are_known_is_that_of_the_conditional(held: list[int]) -> None:
    root = np.random.default_rng(3).standard_normal((4, 4)) * [1.0, 1e-3, 30.0, 1.0]
    covariance = root.T @ root
    free = [k for k in range(4) if k not in held]
    inside = np.linalg.inv(np.linalg.inv(covariance)[np.ix_(free, free)])
    expected = inside[free.index(1), free.index(1)] ** 0.5
    assert deviation_at(covariance, 1, held) == pytest.approx(expected, rel=1e-6)


def test_what_others_tell_wholly_keeps_a_trace_of_its_deviation() -> None:
    same = np.array([[4.0, 4.0], [4.0, 4.0]])
    assert deviation_at(same, 0, [1]) == pytest.approx(2.0 * 1e-4)


def test_shapes_are_the_places_of_what_means_nothing_without_the_size() -> None:
    free = ("R", "V_b", "i_b", "T_s", "w_s")
    assert shapes_of(free, TERMS["brush-drop"]) == [2]
    assert shapes_of(free, TERMS["stribeck"]) == [4]
    assert shapes_of(("R", "T_lc"), LOAD) == []


def test_a_size_is_its_distance_from_nothing_and_more_at_a_known_shape() -> None:
    _, solution = fitted("measured")
    covariance = statistical(solution).covariance
    b = [u.name for u in solution.unknowns].index("B")
    size = abs(solution.values[b]) / covariance[b, b] ** 0.5
    assert module.size_of(solution, b) == pytest.approx(size)
    beside = [k for k in range(len(solution.values)) if k != b]
    known = abs(solution.values[b]) / np.linalg.inv(covariance)[b, b] ** -0.5
    assert module.size_of(solution, b, beside) == pytest.approx(known, rel=1e-3)
    assert known > size


@pytest.mark.parametrize(("name", "unknowns"), [("quadratic-load", 1), ("brush-drop", 2),
                                                ("ripple", 4), ("heating", 4)])  # fmt: skip
def test_a_price_is_schwarzs_for_all_that_the_term_brings(
    name: str, unknowns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its parameters, and a phase of each of two captures; readings that the colour leaves."""
    monkeypatch.setattr(module, "inflation", lambda _: 2.0)
    line = SimpleNamespace(blocks=(SimpleNamespace(count=300.0), SimpleNamespace(count=100.0)))
    rough: Any = SimpleNamespace(
        records=("one", "two"), solution=SimpleNamespace(objective=70.0, records=(line,) * 2)
    )
    found = module.priced(rough, TERMS[name])
    assert found.unknowns == unknowns
    assert found.paid == pytest.approx(70.0 + 2.0 * unknowns * np.log(800.0 / 2.0))
    assert found.open == pytest.approx(20.0)


def narrow() -> Solution:
    """Of six parameters, of which R is held too."""
    _, found = fitted("measured")
    return replace(found, unknowns=found.unknowns[1:], values=found.values[1:])


@cache
def wider(runs: int = 1) -> Fitted:
    """With a load on the shaft, and R held."""
    records, solution = fitted("measured", runs)
    start = {"R": FAULHABER["R"], "T_lc": 1e-10}
    return begin(records, solution, [LOAD], fixed={"R": FAULHABER["R"]}, start=start).roughly()


def test_the_narrower_fit_is_held_against_the_noise_of_the_wider() -> None:
    wide = wider()
    null = module._nested(wide, (), narrow())
    assert wide.free == (*PARAMETERS[1:], "T_lc")
    assert null.free == PARAMETERS[1:]
    assert null.terms == ()
    (one,), (theirs,) = null.records, wide.records
    motor = one.motor(null.solution.values)
    assert motor[0] == pytest.approx(FAULHABER["R"])  # held in both
    assert motor[one.names.index("T_lc")] == 0.0
    assert (one.filters, one.thinned) == (theirs.filters, theirs.thinned)
    assert null.start["T_lc"] == 0.0
    assert null.solution.objective > wide.solution.objective - 0.1  # with one unknown less


def test_a_term_is_weighed_by_its_gain_its_price_and_its_size() -> None:
    wide = wider()
    found = module.weigh(wide, (), narrow(), LOAD)
    null = module._nested(wide, (), narrow()).solution
    assert found.gain == pytest.approx(null.objective - wide.solution.objective, abs=0.1)
    count = sum(b.count for line in wide.solution.records for b in line.blocks)
    assert found.needed == pytest.approx(np.log(count / found.inflation) + module.MARGIN)
    assert found.size == pytest.approx(module.size_of(wide.solution, wide.free.index("T_lc")))
    assert found.left_out is None


SIZE = 12.0  # of a load in its deviations, such as they are at the shape that was found


def moved_by(
    monkeypatch: pytest.MonkeyPatch, *shares: float, name: str = "T_lc"
) -> tuple[Evidence, Evidence]:
    """Of a parameter, before and after, where errors move it by such shares of its deviation, and
    all else by far more.
    """
    wide = wider()
    k = wide.free.index(name)
    value = 1.0 if wide.solution.unknowns[k].log else wide.solution.values[k]
    errors = [np.full(len(wide.free), 1e6) for _ in shares]
    for shift, share in zip(errors, shares, strict=True):
        shift[k] = share * value / SIZE
    asked: list[Any] = []
    hidden: Any = [SimpleNamespace(shared=shift) for shift in errors]
    monkeypatch.setattr(
        module.errors_in_variables, "hidden",
        lambda *of, roughly=False: asked.append((*of, roughly)) or hidden,
    )  # fmt: skip
    before = Evidence(80.0, 2.0, 20.1, SIZE)
    after = module._less_by_input_noise(before, wide, k)
    assert asked == [(wide.solution, wide.records, True)]
    return before, after


def test_where_no_error_is_hidden_evidence_is_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    before, after = moved_by(monkeypatch)
    assert after == before
    before, after = moved_by(monkeypatch, 0.0, 0.0)
    assert after == before


@pytest.mark.parametrize("name", ["T_lc", "J"])  # a distance from 0, and a factor
@pytest.mark.parametrize("shares", [(1.0,), (-0.6, 0.8)])
def test_errors_as_large_as_the_deviation_of_a_size_halve_its_evidence(
    shares: tuple[float, ...], name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The deviation by which it has that size, not the larger one with its shape open."""
    wide = wider()
    k = wide.free.index(name)
    assert wide.solution.unknowns[k].log is (name == "J")
    assert module.size_of(wide.solution, k) != pytest.approx(SIZE, rel=0.2)
    before, after = moved_by(monkeypatch, *shares, name=name)
    assert after.counted == pytest.approx(before.counted / 2.0)
    assert after.size == pytest.approx(before.size / 2.0**0.5)
    assert (after.gain, after.needed) == (80.0, 20.1)
    assert before.supports
    assert not after.suffices  # a counted gain of 40 was twice what is needed


def test_errors_that_move_a_size_along_its_open_shape_leave_it_as_sure_as_it_is_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As of a knee of saturation between two levels: size and knee grow together."""
    wide = wider()
    k, shape = wide.free.index("T_lc"), wide.free.index("J")
    known = module.statistical(wide.solution).covariance.copy()
    known[k, shape] = known[shape, k] = 0.999 * np.sqrt(known[k, k] * known[shape, shape])
    monkeypatch.setattr(module, "statistical", lambda _: SimpleNamespace(covariance=known))
    along = 5.0 * known[shape] / np.sqrt(known[shape, shape])  # by five deviations of the shape
    hidden: Any = [SimpleNamespace(shared=along)]
    monkeypatch.setattr(module.errors_in_variables, "hidden", lambda *_, **__: hidden)
    size = abs(wide.solution.values[k]) / module.deviation_at(known, k, [shape])
    before = Evidence(80.0, 2.0, 20.0, size)
    after = module._less_by_input_noise(before, wide, k, [shape])
    assert after.size == pytest.approx(size)
    assert after.counted == pytest.approx(before.counted)
    assert module._less_by_input_noise(before, wide, k).size < 0.02 * size


@pytest.mark.parametrize(
    ("gain", "size", "less"), [(60.0, 5.0, True), (60.0, 0.0, False), (40.0, 5.0, False)]
)
def test_only_a_size_that_suffices_is_held_against_noise_of_the_voltage(
    gain: float, size: float, less: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of no size there is no deviation, and what does not suffice needs none."""
    wide, asked = wider(), list[Any]()

    def less_by(found: Evidence, *given: Any) -> Evidence:
        asked.append((found.gain, found.size, *given))
        return replace(found, size=1.0)

    monkeypatch.setattr(module, "_nested", lambda *_: replace(wide, free=wide.free[:-1]))
    monkeypatch.setattr(module, "evidence", lambda *_: Evidence(gain, 2.0, 20.0))
    monkeypatch.setattr(module, "size_of", lambda *_: size)
    monkeypatch.setattr(module, "_less_by_input_noise", less_by)
    found = module.weigh(wide, (), narrow(), LOAD)
    k = wide.free.index("T_lc")
    assert asked == ([(gain, size, wide, k, [])] if less else [])
    assert found.size == (1.0 if less else size)
